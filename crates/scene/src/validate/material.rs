//! Materials.

use super::{Check, Range, called};
use crate::{
    Coat, ConductorReflectance, FloatParam, Hair, HairColor, Handle, Material, Origin, Relief, Roughness,
    SceneDesc, Spectrum, Subsurface, SubsurfaceScattering,
};

/// How many materials may stand inside each other.
const MOST_NESTED: u32 = 256;

/// What is known of how a material nests.
#[derive(Clone, Copy, PartialEq)]
enum Nesting {
    Unknown,
    /// On the way from the root to the material at hand.
    Open,
    Depth(u32),
}

impl SceneDesc {
    /// The materials that contain themselves, each found once, with one that closes the circle.
    ///
    /// Handles that lead nowhere count as materials without parts.
    pub fn cyclic_materials(&self) -> Vec<Handle<Material>> {
        self.material_nesting().1
    }

    /// How deep each material nests, and those that contain themselves; in time linear in their number.
    fn material_nesting(&self) -> (Vec<Nesting>, Vec<Handle<Material>>) {
        let mut nesting = vec![Nesting::Unknown; self.materials.len()];
        let mut cyclic = Vec::new();
        let mut stack = Vec::new();
        for (root, _) in self.materials.iter() {
            stack.push(root);
            while let Some(&handle) = stack.last() {
                let parts = self.materials[handle].parts();
                let known = nesting[handle.index()];
                if known == Nesting::Unknown {
                    nesting[handle.index()] = Nesting::Open;
                    for part in parts {
                        match nesting.get(part.index()) {
                            Some(Nesting::Unknown) => stack.push(*part),
                            Some(Nesting::Open) => cyclic.push(handle),
                            Some(Nesting::Depth(_)) | None => {}
                        }
                    }
                    continue;
                }
                stack.pop();
                if known == Nesting::Open {
                    let depth = |part: &Handle<Material>| match nesting.get(part.index()) {
                        Some(Nesting::Depth(depth)) => *depth,
                        _ => 0,
                    };
                    let deepest = parts.iter().map(depth).max().unwrap_or(0);
                    nesting[handle.index()] = Nesting::Depth(deepest + 1);
                }
            }
        }
        cyclic.dedup();
        (nesting, cyclic)
    }
}

impl Check<'_> {
    pub(super) fn materials(&mut self) {
        for (handle, material) in self.scene.materials.iter() {
            let origin = self.scene.materials.origin(handle);
            let owner = called("material", origin);
            self.material(&owner, material, origin);
            for &part in material.parts() {
                self.handle("material", part, &self.scene.materials, &owner, origin);
            }
        }
        let (nesting, cyclic) = self.scene.material_nesting();
        for handle in cyclic {
            let origin = self.scene.materials.origin(handle);
            let message = format!("{} is made of itself", called("material", origin));
            self.error("cyclic-material", origin, message);
        }
        let too_deep = |nesting: &Nesting| matches!(nesting, Nesting::Depth(depth) if *depth > MOST_NESTED);
        if let Some(index) = nesting.iter().position(too_deep)
            && let Some((handle, _)) = self.scene.materials.iter().nth(index)
        {
            let origin = self.scene.materials.origin(handle);
            let owner = called("material", origin);
            let message = format!("{owner} is nested more than {MOST_NESTED} deep");
            self.error("material-too-deep", origin, message);
        }
    }

    fn material(&mut self, owner: &str, material: &Material, origin: &Origin) {
        match material {
            Material::Diffuse { reflectance } => {
                self.spectrum_param(owner, "the reflectance", reflectance, origin);
            }
            Material::Conductor { reflectance, roughness } => {
                self.conductor(owner, reflectance, roughness, origin);
            }
            Material::Dielectric { eta, roughness } => {
                self.index(owner, eta, origin);
                self.roughness(owner, roughness, origin);
            }
            Material::ThinDielectric { eta } => self.index(owner, eta, origin),
            Material::DiffuseTransmission { reflectance, transmittance, scale } => {
                self.spectrum_param(owner, "the reflectance", reflectance, origin);
                self.spectrum_param(owner, "the transmittance", transmittance, origin);
                self.number(|| format!("the scale of {owner}"), *scale, Range::NotNegative, origin);
            }
            Material::CoatedDiffuse { reflectance, coat } => {
                self.spectrum_param(owner, "the reflectance", reflectance, origin);
                self.coat(owner, coat, origin);
            }
            Material::CoatedConductor { reflectance, roughness, coat } => {
                self.conductor(owner, reflectance, roughness, origin);
                self.coat(owner, coat, origin);
            }
            Material::Hair(hair) => self.hair(owner, hair, origin),
            Material::OpenPbr(surface) => {
                for (name, number) in surface.numbers() {
                    self.float_param(owner, &format!("`{name}`"), number, Range::NotNegative, origin);
                }
                for (name, color) in surface.colors() {
                    self.spectrum_param(owner, &format!("`{name}`"), color, origin);
                }
                let luminance = surface.emission_luminance;
                self.number(
                    || format!("`emission_luminance` of {owner}"),
                    luminance,
                    Range::NotNegative,
                    origin,
                );
            }
            Material::Subsurface(subsurface) => self.subsurface(owner, subsurface, origin),
            Material::Measured(brdf) => {
                if let Some(problem) = brdf.problem() {
                    self.error("bad-measurement", origin, format!("the measurement of {owner}: {problem}"));
                }
            }
            Material::Mix { amount, .. } => {
                self.float_param(owner, "the amount", *amount, Range::Finite, origin);
            }
            Material::Relief { relief: Relief::Bump(height), .. } => {
                self.float_param(owner, "the displacement", *height, Range::Finite, origin);
            }
            Material::Relief { relief: Relief::Normals(image), .. } => {
                self.handle("image", *image, &self.scene.images, owner, origin);
            }
            Material::Interface => {}
        }
    }

    fn conductor(
        &mut self,
        owner: &str,
        reflectance: &ConductorReflectance,
        roughness: &Roughness,
        origin: &Origin,
    ) {
        match reflectance {
            ConductorReflectance::Index { eta, k } => {
                self.spectrum_param(owner, "`eta`", eta, origin);
                self.spectrum_param(owner, "`k`", k, origin);
            }
            ConductorReflectance::Normal(reflectance) => {
                self.spectrum_param(owner, "the reflectance", reflectance, origin);
            }
        }
        self.roughness(owner, roughness, origin);
    }

    fn coat(&mut self, owner: &str, coat: &Coat, origin: &Origin) {
        self.roughness(owner, &coat.roughness, origin);
        self.index(owner, &coat.eta, origin);
        self.float_param(owner, "the thickness of the coat", coat.thickness, Range::NotNegative, origin);
        self.float_param(owner, "`g` of the coat", coat.g, Range::Finite, origin);
        if let FloatParam::Constant(g) = coat.g
            && g.abs() >= 1.0
        {
            let message = format!("`g` of the coat of {owner} is {g}: expected between -1 and 1");
            self.error("bad-number", origin, message);
        }
        self.spectrum_param(owner, "the albedo of the coat", &coat.albedo, origin);
        if coat.samples == 0 {
            let message = format!("the coat of {owner} is evaluated by no walks: expected one or more");
            self.error("bad-number", origin, message);
        }
    }

    fn hair(&mut self, owner: &str, hair: &Hair, origin: &Origin) {
        match &hair.color {
            HairColor::Absorption(sigma_a) => {
                self.spectrum_param(owner, "the absorption", sigma_a, origin);
            }
            HairColor::Reflectance(color) => self.spectrum_param(owner, "the colour", color, origin),
            HairColor::Melanin { eumelanin, pheomelanin } => {
                self.float_param(owner, "the eumelanin", *eumelanin, Range::NotNegative, origin);
                self.float_param(owner, "the pheomelanin", *pheomelanin, Range::NotNegative, origin);
            }
        }
        self.float_param(owner, "`eta`", hair.eta, Range::Positive, origin);
        self.float_param(owner, "`beta_m`", hair.beta_m, Range::NotNegative, origin);
        self.float_param(owner, "`beta_n`", hair.beta_n, Range::NotNegative, origin);
        self.float_param(owner, "`alpha`", hair.alpha, Range::Finite, origin);
    }

    fn subsurface(&mut self, owner: &str, subsurface: &Subsurface, origin: &Origin) {
        let Subsurface { scattering, eta, g, roughness } = subsurface;
        let scale = match scattering {
            SubsurfaceScattering::Coefficients { sigma_a, sigma_s, scale } => {
                self.spectrum_param(owner, "`sigma_a`", sigma_a, origin);
                self.spectrum_param(owner, "`sigma_s`", sigma_s, origin);
                scale
            }
            SubsurfaceScattering::Reflectance { reflectance, mean_free_path, scale } => {
                self.spectrum_param(owner, "the reflectance", reflectance, origin);
                self.spectrum_param(owner, "the mean free path", mean_free_path, origin);
                scale
            }
        };
        self.number(|| format!("the scale of {owner}"), *scale, Range::NotNegative, origin);
        self.number(|| format!("`eta` of {owner}"), *eta, Range::Positive, origin);
        self.asymmetry(owner, *g, origin);
        self.roughness(owner, roughness, origin);
    }

    /// Complains unless `eta` can be an index of refraction.
    fn index(&mut self, owner: &str, eta: &Spectrum, origin: &Origin) {
        self.spectrum(&format!("`eta` of {owner}"), eta, origin);
        if let Spectrum::Constant(eta) = *eta {
            self.number(|| format!("`eta` of {owner}"), eta, Range::Positive, origin);
        }
    }

    fn roughness(&mut self, owner: &str, roughness: &Roughness, origin: &Origin) {
        self.float_param(owner, "the roughness", roughness.u, Range::NotNegative, origin);
        if roughness.v != roughness.u {
            self.float_param(owner, "the roughness", roughness.v, Range::NotNegative, origin);
        }
    }
}
