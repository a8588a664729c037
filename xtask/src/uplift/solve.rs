//! Finds the sigmoid of a quadratic polynomial that looks like a given colour.

use super::observer::Observer;

use glam::{DMat3, DVec3};

/// Coefficients of t², t and 1, with t from −1 at 360 nm to 1 at 830 nm.
pub(super) type Coefficients = DVec3;

/// How much a unit of a squared coefficient counts beside a unit of ΔE²: coefficients stay finite where the colour can't be reached.
const REGULARIZATION: f64 = 1e-6;
/// Steps after which the search ends in any case.
const MAX_STEPS: usize = 200;
/// The search ends when the objective falls by less than this share.
const CONVERGED: f64 = 1e-9;

/// An objective and its approximation to second order at a point.
struct Model {
    cost: f64,
    gradient: DVec3,
    hessian: DMat3,
}

/// The coefficients whose sigmoid has the colour of XYZ `target` under the white of `observer`, from `start` on.
///
/// The polynomial is the coefficients' divided by √`brightness`; for dark colours they then depend on the chromaticity
/// alone. Levenberg and Marquardt's method on the difference in CIE L*a*b*, both colours being divided by `brightness`.
///
/// Source: Jakob, Hanika, *A Low-Dimensional Function Space for Efficient Spectral Upsampling*, CGF 38(2), 2019,
/// section 3. Deviations: the scaling by brightness, damping, and a regularisation in place of a limit.
pub(super) fn solve(
    observer: &Observer,
    target: [f64; 3],
    brightness: f64,
    start: Coefficients,
) -> Coefficients {
    let goal = lab(target.map(|value| value / brightness), observer.white);
    let mut at = start;
    let mut model = Model::new(observer, goal, brightness, at);
    let mut damping = 1e-3;
    for _ in 0..MAX_STEPS {
        let Some(step) = model.damped_step(damping) else { break };
        let next = at - step;
        let candidate = Model::new(observer, goal, brightness, next);
        if candidate.cost < model.cost {
            let gain = model.cost - candidate.cost;
            let done = gain <= CONVERGED * model.cost;
            (at, model) = (next, candidate);
            damping = (damping * 0.2).max(1e-12);
            if done {
                break;
            }
        } else {
            damping *= 6.0;
            if damping > 1e12 {
                break;
            }
        }
    }
    at
}

/// XYZ of the sigmoid with these coefficients, Y of white being one, and its derivatives by coefficient.
pub(super) fn xyz(observer: &Observer, at: Coefficients, brightness: f64) -> ([f64; 3], [DVec3; 3]) {
    let scale = 1.0 / brightness.sqrt();
    let (mut color, mut slopes) = ([0.0; 3], [DVec3::ZERO; 3]);
    for &(t, weights) in &observer.samples {
        let powers = DVec3::new(t * t, t, 1.0);
        let x = at.dot(powers) * scale;
        let root = 1.0 / (1.0 + x * x).sqrt();
        let s = 0.5 + 0.5 * x * root;
        let ds = powers * (0.5 * root * root * root * scale);
        for (channel, weight) in weights.into_iter().enumerate() {
            color[channel] += weight * s;
            slopes[channel] += ds * weight;
        }
    }
    (color, slopes)
}

impl Model {
    fn new(observer: &Observer, goal: DVec3, brightness: f64, at: Coefficients) -> Self {
        let (color, slopes) = xyz(observer, at, brightness);
        let color = color.map(|value| value / brightness);
        let residual = lab(color, observer.white) - goal;
        let jacobian = lab_jacobian(color, observer.white, slopes.map(|slope| slope / brightness));
        let transposed = jacobian.transpose();
        Self {
            cost: residual.length_squared() + REGULARIZATION * at.length_squared(),
            gradient: transposed * residual + at * REGULARIZATION,
            hessian: transposed * jacobian + DMat3::from_diagonal(DVec3::splat(REGULARIZATION)),
        }
    }

    /// The step that the model asks for, its diagonal enlarged by `damping`; `None` if the matrix is singular.
    fn damped_step(&self, damping: f64) -> Option<DVec3> {
        let diagonal =
            DVec3::new(self.hessian.x_axis.x, self.hessian.y_axis.y, self.hessian.z_axis.z) * damping;
        let step = (self.hessian + DMat3::from_diagonal(diagonal)).inverse() * self.gradient;
        step.is_finite().then_some(step)
    }
}

/// The border of the linear piece of L*a*b*, δ = 6/29 (CIE 15:2004, equation 8.7).
const DELTA: f64 = 6.0 / 29.0;

fn lab_root(x: f64) -> f64 {
    if x > DELTA * DELTA * DELTA { x.cbrt() } else { x / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
}

fn lab_root_slope(x: f64) -> f64 {
    if x > DELTA * DELTA * DELTA { 1.0 / (3.0 * x.cbrt().powi(2)) } else { 1.0 / (3.0 * DELTA * DELTA) }
}

/// CIE 1976 L*a*b* of XYZ (CIE 15:2004, equations 8.3 to 8.8).
fn lab(xyz: [f64; 3], white: [f64; 3]) -> DVec3 {
    let [x, y, z] = std::array::from_fn(|i| lab_root(xyz[i] / white[i]));
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// Derivatives of [`lab`], whose rows are L*, a* and b*, given those of XYZ.
fn lab_jacobian(xyz: [f64; 3], white: [f64; 3], slopes: [DVec3; 3]) -> DMat3 {
    let [x, y, z] = std::array::from_fn(|i| slopes[i] * (lab_root_slope(xyz[i] / white[i]) / white[i]));
    DMat3::from_cols(y * 116.0, (x - y) * 500.0, (y - z) * 200.0).transpose()
}
