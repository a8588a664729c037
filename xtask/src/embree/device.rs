//! The library and its devices.

use std::ffi::{CString, c_void};
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};

use super::ffi::{self, Api, DeviceHandle};
use super::install;
use crate::Result;

/// The loaded library.
#[derive(Clone, Debug)]
pub(crate) struct Embree {
    api: Arc<Api>,
}

/// The instructions that a device may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Isa {
    /// What Embree chooses.
    Automatic,
    /// 256 bits.
    Avx2,
    /// 512 bits.
    Avx512,
}

/// How a device is made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    pub(crate) isa: Isa,
    /// Threads that build. While several devices exist, each may use as many as the one that has most.
    pub(crate) threads: usize,
    /// Whether allocations are counted.
    pub(crate) counts_memory: bool,
}

/// A device of Embree's: what scenes are made with.
#[derive(Debug)]
pub(crate) struct Device {
    pub(super) api: Arc<Api>,
    pub(super) handle: DeviceHandle,
    /// What the memory monitor counts, at an address that stays when the device is moved; freed after the device is released.
    bytes: Arc<AtomicI64>,
}

// SAFETY: Embree's devices are reference-counted objects that any thread may use, by its documentation; what is called here for
// them (properties, errors, making scenes) is synchronised there.
unsafe impl Send for Device {}
// SAFETY: as above.
unsafe impl Sync for Device {}

impl Embree {
    /// Loads the library, after fetching it if need be.
    ///
    /// # Errors
    /// It can't be fetched or loaded.
    pub(crate) fn open() -> Result<Self> {
        let path = install::library()?;
        let api = Api::load(&path).map_err(|error| format!("can't load `{}`: {error}", path.display()))?;
        Ok(Self { api: Arc::new(api) })
    }

    /// A new device; `None` if the processor lacks the instructions.
    ///
    /// # Errors
    /// Embree refuses, or uses other instructions than it was told.
    pub(crate) fn device(&self, settings: Settings) -> Result<Option<Device>> {
        let isa = match settings.isa {
            Isa::Automatic => "",
            Isa::Avx2 => ",isa=avx2",
            Isa::Avx512 => ",isa=avx512",
        };
        if !settings.isa.is_supported() {
            return Ok(None);
        }
        let configuration = CString::new(format!("threads={}{isa}", settings.threads))?;
        // SAFETY: the string is terminated by a zero and outlives the call.
        let handle = unsafe { (self.api.new_device)(configuration.as_ptr()) };
        if handle.is_null() {
            return Err(format!("Embree makes no device for {configuration:?}").into());
        }
        let device = Device { api: Arc::clone(&self.api), handle, bytes: Arc::default() };
        if settings.counts_memory {
            let counter = Arc::as_ptr(&device.bytes);
            // SAFETY: the function has the monitor's type, and the counter it is given, which is only ever shared, is freed after the
            // device is released.
            unsafe {
                (device.api.set_memory_monitor)(handle, Some(count_bytes), counter.cast_mut().cast());
            }
        }
        device.check()?;
        let widths = (device.property(ffi::PROPERTY_NATIVE_RAY8_SUPPORTED), device.is_512_bits_wide());
        let expected = match settings.isa {
            Isa::Automatic => widths,
            Isa::Avx2 => (1, false),
            Isa::Avx512 => (1, true),
        };
        if widths != expected {
            return Err(format!("Embree does not use {:?} although told to", settings.isa).into());
        }
        Ok(Some(device))
    }
}

impl Isa {
    #[cfg(target_arch = "x86_64")]
    fn is_supported(self) -> bool {
        match self {
            Self::Automatic => true,
            Self::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512cd")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512vl")
            }
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn is_supported(self) -> bool {
        self == Self::Automatic
    }
}

impl Device {
    /// Whether traversal uses 512-bit registers: this is when packets of sixteen are native.
    pub(crate) fn is_512_bits_wide(&self) -> bool {
        self.property(ffi::PROPERTY_NATIVE_RAY16_SUPPORTED) == 1
    }

    /// Major and minor version.
    pub(crate) fn version(&self) -> (isize, isize) {
        (self.property(ffi::PROPERTY_VERSION_MAJOR), self.property(ffi::PROPERTY_VERSION_MINOR))
    }

    /// Bytes that are allocated, if they are counted.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed).max(0).unsigned_abs()
    }

    fn property(&self, property: i32) -> isize {
        // SAFETY: the handle is that of a device that has not been released.
        unsafe { (self.api.device_property)(self.handle, property) }
    }

    /// Tells the first error since the last call.
    ///
    /// # Errors
    /// There was one.
    pub(super) fn check(&self) -> Result<()> {
        // SAFETY: as above.
        match unsafe { (self.api.device_error)(self.handle) } {
            0 => Ok(()),
            code => Err(format!("Embree reports error {code}").into()),
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: the handle came from `rtcNewDevice` and is released once; scenes hold the device until they are released.
        unsafe {
            (self.api.release_device)(self.handle);
        }
    }
}

/// Embree's memory monitor: adds what is allocated or freed; never objects.
///
/// # Safety
/// `counter` points to an `AtomicI64`.
unsafe extern "C" fn count_bytes(counter: *mut c_void, bytes: isize, _happened: bool) -> bool {
    // SAFETY: required of the caller, which is Embree with the pointer given beside this function.
    let counter = unsafe { &*counter.cast::<AtomicI64>() };
    counter.fetch_add(bytes as i64, Ordering::Relaxed);
    true
}
