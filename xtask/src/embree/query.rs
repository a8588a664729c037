//! Queries: slices of rays in, hits written beside them.
//!
//! The rays are prepared beforehand, so that a measurement contains the traversal and the writing of hits alone.

use std::ffi::c_int;
use std::ptr;

use sahl_math::Ray as SahlRay;

use super::ffi::{
    Arguments, Hit, INVALID, QUERY_FLAG_COHERENT, QUERY_FLAG_INCOHERENT, Ray, RayHit, RayHit16,
};
use super::scene::Scene;

/// Sixteen valid rays.
#[repr(align(64))]
struct Valid([c_int; 16]);

/// The nearest hit of each ray, one by one.
pub(crate) fn intersect(scene: &Scene, rays: &mut [RayHit]) {
    let intersect1 = scene.device.api.intersect1;
    for ray in rays {
        // SAFETY: the scene is alive and committed and `ray` a valid `RTCRayHit`, borrowed alone; null stands for default arguments.
        unsafe { intersect1(scene.handle, ray, ptr::null_mut()) };
    }
}

/// The nearest hits of packets of sixteen rays. `coherent` hints that rays of a packet are alike.
pub(crate) fn intersect_packets(scene: &Scene, packets: &mut [RayHit16], coherent: bool) {
    let intersect16 = scene.device.api.intersect16;
    let valid = Valid([-1; 16]);
    let mut arguments = Arguments {
        flags: if coherent { QUERY_FLAG_COHERENT } else { QUERY_FLAG_INCOHERENT },
        feature_mask: u32::MAX,
        context: ptr::null_mut(),
        filter: ptr::null_mut(),
        intersect: ptr::null_mut(),
        minimum_width_distance_factor: 0.0,
        reserved: [0; 7],
    };
    for packet in packets {
        // SAFETY: the scene is alive and committed; mask, packet and arguments have the layout and the alignment (64 bytes) of Embree's
        // structures, and the packet is borrowed alone.
        unsafe { intersect16(valid.0.as_ptr(), scene.handle, packet, &raw mut arguments) };
    }
}

/// Whether anything lies on each ray: its `tfar` becomes minus infinity if so.
pub(crate) fn occluded(scene: &Scene, rays: &mut [Ray]) {
    let occluded1 = scene.device.api.occluded1;
    for ray in rays {
        // SAFETY: the scene is alive and committed and `ray` a valid `RTCRay`, borrowed alone; null stands for default arguments.
        unsafe { occluded1(scene.handle, ray, ptr::null_mut()) };
    }
}

/// A ray as Embree wants it.
pub(crate) fn single(ray: &SahlRay) -> Ray {
    Ray {
        origin: ray.origin.into(),
        tnear: ray.t_min,
        direction: ray.direction.into(),
        time: 0.0,
        tfar: ray.t_max,
        mask: u32::MAX,
        id: 0,
        flags: 0,
    }
}

impl RayHit {
    /// The ray before its query.
    pub(crate) fn new(ray: &SahlRay) -> Self {
        let hit = Hit { geometry: INVALID, instance: INVALID, ..Hit::default() };
        Self { ray: single(ray), hit }
    }

    /// Makes the ray fit for another query.
    pub(crate) fn reset(&mut self, ray: &SahlRay) {
        self.ray.tfar = ray.t_max;
        self.hit.geometry = INVALID;
    }
}

/// Packets of the rays, whose number must be a multiple of sixteen; others are left out.
pub(crate) fn pack(rays: &[SahlRay]) -> Vec<RayHit16> {
    rays.chunks_exact(16).map(packet).collect()
}

fn packet(rays: &[SahlRay]) -> RayHit16 {
    let mut packet = RayHit16 {
        mask: [u32::MAX; 16],
        geometry: [INVALID; 16],
        instance: [INVALID; 16],
        ..RayHit16::default()
    };
    for (i, ray) in rays.iter().enumerate() {
        for axis in 0..3 {
            packet.origin[axis][i] = ray.origin[axis];
            packet.direction[axis][i] = ray.direction[axis];
        }
        packet.tnear[i] = ray.t_min;
        packet.tfar[i] = ray.t_max;
    }
    packet
}

impl RayHit16 {
    /// Makes the packet fit for another query of the same rays.
    pub(crate) fn reset(&mut self, rays: &[SahlRay]) {
        for (tfar, ray) in self.tfar.iter_mut().zip(rays) {
            *tfar = ray.t_max;
        }
        self.geometry = [INVALID; 16];
    }
}
