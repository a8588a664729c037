//! Instances, and shapes that move, as placed groups of the accelerator.
//!
//! A shape that moves is a group of its own with one moving instance, so that every kind of shape can move, and what stands still pays
//! nothing. A moving shape of an object is placed once for each instance of the object, since groups don't nest.

use sahl_accel::{Instance, Placement};
use sahl_math::{AnimatedTransform, Transform};
use sahl_scene::{Handle, Object, SceneDesc, Shape};

/// Collects what is placed by an instance, and the groups that are not objects.
pub(super) struct Placements {
    pub(super) instances: Vec<Instance>,
    /// Those of the shapes that move, one geometry each; they come after those of the objects.
    pub(super) groups: Vec<Vec<u32>>,
    /// How many groups come before.
    objects: u32,
    /// The moving shapes of objects.
    parts: Vec<Part>,
}

/// A shape of an object that moves in it.
struct Part {
    object: Handle<Object>,
    group: u32,
    motion: AnimatedTransform,
}

impl Placements {
    pub(super) fn new(description: &SceneDesc) -> Self {
        let objects = description.objects.len() as u32;
        Self { instances: Vec::new(), groups: Vec::new(), objects, parts: Vec::new() }
    }

    /// Places a geometry that moves in the world.
    pub(super) fn add_shape(&mut self, geometry: u32, motion: &AnimatedTransform) {
        let group = self.group_of(geometry);
        self.instances.push(Instance { group, to_world: motion.clone().into() });
    }

    /// Adds a geometry that moves in an object; to be called before the object is placed.
    pub(super) fn add_part(&mut self, object: Handle<Object>, geometry: u32, motion: &AnimatedTransform) {
        let group = self.group_of(geometry);
        self.parts.push(Part { object, group, motion: motion.clone() });
    }

    /// Places an object, and what moves in it.
    pub(super) fn add_instance(&mut self, instance: &sahl_scene::Instance) {
        let to_world = match &instance.motion {
            Some(motion) => Placement::Moving(motion.clone()),
            None => instance.object_to_world.into(),
        };
        for part in self.parts.iter().filter(|part| part.object == instance.object) {
            let to_world = product(&to_world, &part.motion);
            self.instances.push(Instance { group: part.group, to_world });
        }
        self.instances.push(Instance { group: instance.object.index() as u32, to_world });
    }

    fn group_of(&mut self, geometry: u32) -> u32 {
        self.groups.push(vec![geometry]);
        self.objects + self.groups.len() as u32 - 1
    }
}

/// From a shape's space to that in which its geometry is kept: its own if it moves, as an instance moves it.
pub(super) fn to_parent(shape: &Shape) -> Transform {
    if shape.motion.is_some() { Transform::IDENTITY } else { shape.shape_to_world }
}

/// A motion in something that is placed, or moves itself.
///
/// Deviation from pbrt-v4, which maps rays twice: the maps at both ends are multiplied, and the products are interpolated. That is the same
/// where the outer map only shifts while the shutter is open, and is at most a similarity; otherwise the ways between the ends differ.
fn product(outer: &Placement, inner: &AnimatedTransform) -> Placement {
    let times = match outer {
        Placement::Moving(motion) if motion.times() != inner.times() => [0.0, 1.0],
        _ => inner.times(),
    };
    // The maps of a motion are those of its ends before and after it: asked for at the ends of the shutter, if the motions differ.
    let ends = |place: usize| match outer {
        Placement::Still(transform) => (*transform, inner.ends()[place]),
        Placement::Moving(motion) if motion.times() == inner.times() => {
            (motion.ends()[place], inner.ends()[place])
        }
        Placement::Moving(motion) => (motion.at(times[place]), inner.at(times[place])),
    };
    let [start, end] = [0, 1].map(|place| {
        let (outer, inner) = ends(place);
        outer.after(&inner).unwrap_or(inner)
    });
    let motion = AnimatedTransform::new(start, end, times).map(|motion| motion.about(inner.pivot()));
    motion.map_or(Placement::Still(start), Placement::from)
}
