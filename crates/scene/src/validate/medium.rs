//! Media, and the surfaces that part them.

use super::{Check, NOWHERE, Range, called};
use crate::{
    CloudMedium, Coefficients, Emission, Grid, GridMedium, GridSource, Handle, Medium, MediumInterface,
    Origin, Region, RgbGridMedium, SparseGrid, SparseMedium, TemperatureScale,
};

impl Check<'_> {
    pub(super) fn media(&mut self) {
        for (handle, medium) in self.scene.media.iter() {
            let origin = self.scene.media.origin(handle);
            let owner = called("medium", origin);
            match medium {
                Medium::Homogeneous { coefficients, emission } => {
                    self.coefficients(&owner, coefficients, origin);
                    self.emission(&owner, emission.as_ref(), origin);
                }
                Medium::Grid(medium) => self.grid_medium(&owner, medium, origin),
                Medium::RgbGrid(medium) => self.rgb_grid_medium(&owner, medium, origin),
                Medium::Cloud(medium) => {
                    let CloudMedium { coefficients, region, density, wispiness, frequency } = medium;
                    self.coefficients(&owner, coefficients, origin);
                    self.region(&owner, region, origin);
                    let numbers = [("density", density), ("wispiness", wispiness), ("frequency", frequency)];
                    for (what, value) in numbers {
                        self.number(|| format!("the {what} of {owner}"), *value, Range::NotNegative, origin);
                    }
                }
                Medium::Sparse(medium) => self.sparse_medium(&owner, medium, origin),
            }
        }
        self.medium("the camera", self.scene.camera.medium, &NOWHERE);
    }

    fn coefficients(&mut self, owner: &str, coefficients: &Coefficients, origin: &Origin) {
        let Coefficients { sigma_a, sigma_s, scale, g } = coefficients;
        self.spectrum(&format!("`sigma_a` of {owner}"), sigma_a, origin);
        self.spectrum(&format!("`sigma_s` of {owner}"), sigma_s, origin);
        self.number(|| format!("the scale of {owner}"), *scale, Range::NotNegative, origin);
        self.asymmetry(owner, *g, origin);
    }

    /// The parameter of the phase function.
    pub(super) fn asymmetry(&mut self, owner: &str, g: f32, origin: &Origin) {
        if !(g > -1.0 && g < 1.0) {
            let message = format!("`g` of {owner} is {g}: expected more than -1 and less than 1");
            self.error("bad-number", origin, message);
        }
    }

    fn emission(&mut self, owner: &str, emission: Option<&Emission>, origin: &Origin) {
        if let Some(Emission { radiance, scale }) = emission {
            self.spectrum(&format!("the emission of {owner}"), radiance, origin);
            self.emission_scale(owner, *scale, origin);
        }
    }

    fn emission_scale(&mut self, owner: &str, scale: f32, origin: &Origin) {
        self.number(|| format!("the scale of the emission of {owner}"), scale, Range::NotNegative, origin);
    }

    fn region(&mut self, owner: &str, region: &Region, origin: &Origin) {
        let bounds = region.bounds;
        if bounds.is_empty() || !(bounds.min.is_finite() && bounds.max.is_finite()) {
            let message = format!("the box of {owner} is empty or not finite");
            self.error("bad-volume", origin, message);
        }
    }

    /// A value for each cell, and each of its `numbers` finite.
    fn grid<T>(
        &mut self,
        (owner, what): (&str, &str),
        grid: &Grid<T>,
        numbers: impl Fn(&T) -> &[f32],
        origin: &Origin,
    ) {
        if !grid.is_complete() {
            let [x, y, z] = grid.resolution;
            let message =
                format!("{what} of {owner} has {} values for {x} × {y} × {z} cells", grid.values.len());
            self.error("bad-volume", origin, message);
        }
        if grid.values.iter().any(|value| numbers(value).iter().any(|number| !number.is_finite())) {
            self.error("bad-volume", origin, format!("{what} of {owner} holds a number that is not finite"));
        }
    }

    fn grid_medium(&mut self, owner: &str, medium: &GridMedium, origin: &Origin) {
        let one = std::slice::from_ref;
        self.coefficients(owner, &medium.coefficients, origin);
        self.region(owner, &medium.region, origin);
        self.grid((owner, "the density"), &medium.density, one, origin);
        let Some(emission) = &medium.emission else { return };
        self.emission_scale(owner, emission.scale, origin);
        match &emission.source {
            GridSource::Spectrum(spectrum) => {
                self.spectrum(&format!("the emission of {owner}"), spectrum, origin);
            }
            GridSource::Temperature(grid, scale) => {
                self.grid((owner, "the temperature"), grid, one, origin);
                self.temperature(owner, *scale, origin);
            }
        }
        if let Some(scales) = &emission.scales {
            self.grid((owner, "the scale of the emission"), scales, one, origin);
        }
    }

    fn temperature(&mut self, owner: &str, scale: TemperatureScale, origin: &Origin) {
        self.number(|| format!("the offset of temperatures of {owner}"), scale.offset, Range::Finite, origin);
        self.number(|| format!("the scale of temperatures of {owner}"), scale.scale, Range::Finite, origin);
    }

    fn rgb_grid_medium(&mut self, owner: &str, medium: &RgbGridMedium, origin: &Origin) {
        self.region(owner, &medium.region, origin);
        self.asymmetry(owner, medium.g, origin);
        self.number(|| format!("the scale of {owner}"), medium.scale, Range::NotNegative, origin);
        self.emission_scale(owner, medium.emission_scale, origin);
        let grids =
            [("`sigma_a`", &medium.sigma_a), ("`sigma_s`", &medium.sigma_s), ("`Le`", &medium.emission)];
        for (what, grid) in grids {
            if let Some(grid) = grid {
                self.grid((owner, what), grid, |rgb| rgb.as_slice(), origin);
            }
        }
    }

    fn sparse_medium(&mut self, owner: &str, medium: &SparseMedium, origin: &Origin) {
        self.coefficients(owner, &medium.coefficients, origin);
        self.emission_scale(owner, medium.emission_scale, origin);
        self.sparse_grid((owner, "the density"), &medium.density, origin);
        if let Some((grid, scale)) = &medium.temperature {
            self.sparse_grid((owner, "the temperature"), grid, origin);
            self.temperature(owner, *scale, origin);
        }
    }

    fn sparse_grid(&mut self, (owner, what): (&str, &str), grid: &SparseGrid, origin: &Origin) {
        if !grid.is_complete() {
            self.error("bad-volume", origin, format!("the table of {what} of {owner} leads nowhere"));
        }
        let finite = grid.bounds.min.is_finite() && grid.bounds.max.is_finite();
        if !finite || !grid.background.is_finite() || grid.values.iter().any(|value| !value.is_finite()) {
            self.error("bad-volume", origin, format!("{what} of {owner} holds a number that is not finite"));
        }
    }

    pub(super) fn medium_interface(&mut self, owner: &str, media: Option<MediumInterface>, origin: &Origin) {
        if let Some(MediumInterface { inside, outside }) = media {
            self.medium(owner, inside, origin);
            self.medium(owner, outside, origin);
        }
    }

    fn medium(&mut self, owner: &str, medium: Option<Handle<Medium>>, origin: &Origin) {
        if let Some(medium) = medium {
            self.handle("medium", medium, &self.scene.media, owner, origin);
        }
    }
}
