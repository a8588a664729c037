//! Motion: what the transforms at both ends make of the time that the shutter is open.
//!
//! `TransformTimes` says when the motion begins and ends, in the seconds of the shutter; the scene counts in fractions of the time that
//! the shutter is open. Before the motion begins things stand as at its start, and after it has ended as at its end.
//!
//! Between the two, the origin of what moves goes along a straight line. Of an instance, it is the point of its object that is where the
//! camera is in the world: pbrt-v4 takes maps apart in a space about the camera, which shows where they turn. Files are rendered as pbrt
//! renders them by default.
//!
//! ```text
//! TransformTimes 0 1
//! Camera "perspective" "float shutteropen" 0 "float shutterclose" 0.5
//! ...
//! ActiveTransform EndTime  Translate 1 0 0  ActiveTransform All
//! Shape "sphere"
//! ```

use sahl_math::{AnimatedTransform, Transform, Vec3};
use sahl_scene::Span;

use super::interpreter::Interpreter;

/// Where something is when the shutter opens, and its way if it moves.
pub(super) type Placed = (Transform, Option<Box<AnimatedTransform>>);

/// What is placed.
#[derive(Clone, Copy)]
pub(super) struct Mover<'a> {
    /// What messages call it.
    pub(super) what: &'a str,
    /// Where messages point.
    pub(super) span: Span,
    /// The point that goes along a straight line, in the space that is mapped.
    pub(super) pivot: Vec3,
}

/// Where a camera is halfway through its motion, by the maps from its space to the world at both ends.
pub(super) fn middle_of_camera([start, end]: [Transform; 2]) -> Vec3 {
    let motion = AnimatedTransform::new(start, end, [0.0, 1.0]);
    motion.map_or(start, |motion| motion.at(0.5)).point(Vec3::ZERO)
}

impl Interpreter<'_> {
    /// Where the transforms in force put something, and how they move it.
    pub(super) fn placement(&self, mover: Mover<'_>) -> Placed {
        self.placed(mover, self.state.transforms, self.cx.scene.camera.shutter)
    }

    /// Where something is, mapped by `start` and `end` when the motion begins and ends, while the shutter is open from `open` to
    /// `close`.
    ///
    /// A motion through a singular map, which mirrors at one end alone, is reported and does not happen.
    pub(super) fn placed(
        &self,
        mover: Mover<'_>,
        [start, end]: [Transform; 2],
        [open, close]: [f32; 2],
    ) -> Placed {
        if start == end {
            return (start, None);
        }
        let pivot = <[f32; 3]>::from(mover.pivot).map(f64::from);
        let motion = |times| AnimatedTransform::new(start, end, times).map(|motion| motion.about(pivot));
        let [from, to] = self.transform_times;
        if close <= open || to <= from {
            // A moment of the motion, or a motion in no time.
            let progress = if to > from { (open - from) / (to - from) } else { f32::from(open > from) };
            let moment = motion([0.0, 1.0]).map(|motion| motion.at(progress));
            return (moment.unwrap_or_else(|| self.refuse_motion(start, mover)), None);
        }
        let times = [from, to].map(|time| (time - open) / (close - open));
        match motion(times) {
            Some(motion) => (motion.at(0.0), Some(Box::new(motion))),
            None => (self.refuse_motion(start, mover), None),
        }
    }

    /// Tells that a motion can't be followed.
    fn refuse_motion(&self, start: Transform, Mover { what, span, .. }: Mover<'_>) -> Transform {
        let message = format!(
            "the motion passes through a singular map, since it mirrors at one end alone: {what} stays where it is at the start"
        );
        self.report().warning("singular-motion", span, message);
        start
    }
}
