//! The types and functions of Embree's C interface that are used, with its names in Rust's spelling.
//!
//! Source: `rtcore_ray.h`, `rtcore_scene.h`, `rtcore_device.h`, `rtcore_geometry.h` of Embree 4.4, with
//! `RTC_GEOMETRY_INSTANCE_ARRAY` and one level of instances, which is how the library is delivered.

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::mem;
use std::path::Path;

use libloading::Library;

/// The number of no geometry.
pub(crate) const INVALID: c_uint = c_uint::MAX;

pub(super) const GEOMETRY_TYPE_TRIANGLE: c_int = 0;
pub(super) const BUFFER_TYPE_INDEX: c_int = 0;
pub(super) const BUFFER_TYPE_VERTEX: c_int = 1;
pub(super) const FORMAT_UINT3: c_int = 0x5003;
pub(super) const FORMAT_FLOAT3: c_int = 0x9003;
pub(super) const SCENE_FLAG_NONE: c_int = 0;
pub(super) const SCENE_FLAG_ROBUST: c_int = 1 << 2;
pub(super) const BUILD_QUALITY_MEDIUM: c_int = 1;
pub(super) const BUILD_QUALITY_HIGH: c_int = 2;
pub(super) const PROPERTY_VERSION_MAJOR: c_int = 1;
pub(super) const PROPERTY_VERSION_MINOR: c_int = 2;
pub(super) const PROPERTY_NATIVE_RAY8_SUPPORTED: c_int = 33;
pub(super) const PROPERTY_NATIVE_RAY16_SUPPORTED: c_int = 34;
pub(super) const QUERY_FLAG_INCOHERENT: c_uint = 0;
pub(super) const QUERY_FLAG_COHERENT: c_uint = 1 << 16;

/// `RTCDevice`.
pub(super) type DeviceHandle = *mut c_void;
/// `RTCScene`.
pub(super) type SceneHandle = *mut c_void;
/// `RTCGeometry`.
pub(super) type GeometryHandle = *mut c_void;
/// `RTCMemoryMonitorFunction`: pointer of the user, bytes more or less, whether it has happened already.
pub(super) type MemoryMonitor = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;

/// `RTCRay`.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(16))]
pub(crate) struct Ray {
    pub(crate) origin: [f32; 3],
    pub(crate) tnear: f32,
    pub(crate) direction: [f32; 3],
    pub(crate) time: f32,
    /// After a query: the parameter of the hit; minus infinity if the query was for occlusion.
    pub(crate) tfar: f32,
    pub(crate) mask: c_uint,
    pub(crate) id: c_uint,
    pub(crate) flags: c_uint,
}

/// `RTCHit`.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(16))]
pub(crate) struct Hit {
    pub(crate) normal: [f32; 3],
    pub(crate) u: f32,
    pub(crate) v: f32,
    pub(crate) primitive: c_uint,
    pub(crate) geometry: c_uint,
    pub(crate) instance: c_uint,
    pub(crate) instance_primitive: c_uint,
}

/// `RTCRayHit`.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct RayHit {
    pub(crate) ray: Ray,
    pub(crate) hit: Hit,
}

/// `RTCRayHit16`: sixteen of each field of [`Ray`] and [`Hit`].
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct RayHit16 {
    pub(crate) origin: [[f32; 16]; 3],
    pub(crate) tnear: [f32; 16],
    pub(crate) direction: [[f32; 16]; 3],
    pub(crate) time: [f32; 16],
    pub(crate) tfar: [f32; 16],
    pub(crate) mask: [c_uint; 16],
    pub(crate) id: [c_uint; 16],
    pub(crate) flags: [c_uint; 16],
    pub(crate) normal: [[f32; 16]; 3],
    pub(crate) u: [f32; 16],
    pub(crate) v: [f32; 16],
    pub(crate) primitive: [c_uint; 16],
    pub(crate) geometry: [c_uint; 16],
    pub(crate) instance: [c_uint; 16],
    pub(crate) instance_primitive: [c_uint; 16],
}

/// `RTCIntersectArguments`. Null pointers and zeros are the defaults, except of the mask; what follows the known fields
/// leaves room for those of other configurations of the library.
#[derive(Debug)]
#[repr(C)]
pub(super) struct Arguments {
    pub(super) flags: c_uint,
    pub(super) feature_mask: c_uint,
    pub(super) context: *mut c_void,
    pub(super) filter: *mut c_void,
    pub(super) intersect: *mut c_void,
    pub(super) minimum_width_distance_factor: f32,
    pub(super) reserved: [u32; 7],
}

/// Declares [`Api`] and reads its functions from the library, each under its own name there.
macro_rules! functions {
    ($($field:ident = $symbol:ident($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// The functions of the library, which stays loaded until the program ends.
        #[derive(Debug)]
        pub(super) struct Api {
            $(pub(super) $field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Api {
            /// Loads the library at `path`.
            ///
            /// # Errors
            /// There is no such library, or it lacks a function.
            pub(super) fn load(path: &Path) -> Result<Self, libloading::Error> {
                // SAFETY: the file is Embree's library; its initialisers and those of its dependencies set up tables of their own
                // and depend on nothing of this program.
                let library = unsafe { Library::new(path) }?;
                $(
                    // SAFETY: the symbol is the function of that name in Embree's C interface, whose types are those of the
                    // declaration; the library is never unloaded.
                    let $field = unsafe {
                        *library.get::<unsafe extern "C" fn($($argument),*) $(-> $result)?>(stringify!($symbol))?
                    };
                )*
                // Its threads may run on after the last device is released, so its code must stay.
                mem::forget(library);
                Ok(Self { $($field),* })
            }
        }
    };
}

functions! {
    new_device = rtcNewDevice(*const c_char) -> DeviceHandle;
    release_device = rtcReleaseDevice(DeviceHandle);
    device_error = rtcGetDeviceError(DeviceHandle) -> c_int;
    device_property = rtcGetDeviceProperty(DeviceHandle, c_int) -> isize;
    set_memory_monitor = rtcSetDeviceMemoryMonitorFunction(DeviceHandle, Option<MemoryMonitor>, *mut c_void);
    new_scene = rtcNewScene(DeviceHandle) -> SceneHandle;
    release_scene = rtcReleaseScene(SceneHandle);
    set_scene_flags = rtcSetSceneFlags(SceneHandle, c_int);
    set_scene_build_quality = rtcSetSceneBuildQuality(SceneHandle, c_int);
    commit_scene = rtcCommitScene(SceneHandle);
    new_geometry = rtcNewGeometry(DeviceHandle, c_int) -> GeometryHandle;
    release_geometry = rtcReleaseGeometry(GeometryHandle);
    set_shared_geometry_buffer = rtcSetSharedGeometryBuffer(
        GeometryHandle, c_int, c_uint, c_int, *const c_void, usize, usize, usize
    );
    commit_geometry = rtcCommitGeometry(GeometryHandle);
    attach_geometry = rtcAttachGeometry(SceneHandle, GeometryHandle) -> c_uint;
    intersect1 = rtcIntersect1(SceneHandle, *mut RayHit, *mut Arguments);
    intersect16 = rtcIntersect16(*const c_int, SceneHandle, *mut RayHit16, *mut Arguments);
    occluded1 = rtcOccluded1(SceneHandle, *mut Ray, *mut Arguments);
}
