//! Textures, which may refer to each other.

use super::{Check, Range, called};
use crate::{
    FaceTexture, Handle, ImageTexture, Origin, SolidNoise, SpectrumParam, Texture, TextureFilter,
    TextureMapping, UvMapping,
};

/// Textures may be nested so deep. Deeper ones are a mistake, and evaluating them could exhaust the stack.
const DEEPEST: usize = 64;

/// How far the search for cycles has come with a texture.
#[derive(Clone, Copy, PartialEq)]
enum State {
    New,
    /// Its parts are being looked at: meeting it again closes a cycle.
    Open,
    /// It holds so many textures in each other, itself included.
    Done(usize),
}

impl Check<'_> {
    pub(super) fn textures(&mut self) {
        for (handle, texture) in self.scene.textures.iter() {
            self.texture(handle, texture);
        }
        self.nesting();
    }

    fn texture(&mut self, handle: Handle<Texture>, texture: &Texture) {
        let scene = self.scene;
        let origin = scene.textures.origin(handle);
        let owner = called("texture", origin);
        match texture {
            Texture::Constant(spectrum) => self.spectrum(&format!("the value of {owner}"), spectrum, origin),
            Texture::Scale { texture, scale } => {
                self.spectrum_param(&owner, "the value", texture, origin);
                self.float_param(&owner, "the scale", *scale, Range::Finite, origin);
            }
            Texture::Mix { first, second, amount } => {
                self.pair(&owner, [first, second], origin);
                self.float_param(&owner, "the amount", *amount, Range::Finite, origin);
            }
            Texture::DirectionMix { first, second, direction } => {
                self.pair(&owner, [first, second], origin);
                if direction.try_normalize().is_none() {
                    let [x, y, z] = <[f32; 3]>::from(*direction);
                    let message =
                        format!("the direction of {owner} is ({x}, {y}, {z}): expected one that is not zero");
                    self.error("bad-number", origin, message);
                }
            }
            Texture::Bilerp { mapping, corners } => {
                for corner in corners {
                    self.spectrum_param(&owner, "the value", corner, origin);
                }
                self.mapping(&owner, mapping, origin);
            }
            Texture::Checkerboard { mapping, even, odd } => {
                self.pair(&owner, [even, odd], origin);
                self.mapping(&owner, mapping, origin);
            }
            Texture::SolidCheckerboard { even, odd, .. } => self.pair(&owner, [even, odd], origin),
            Texture::Dots { mapping, inside, outside } => {
                self.pair(&owner, [inside, outside], origin);
                self.mapping(&owner, mapping, origin);
            }
            Texture::Windy { .. } => {}
            Texture::Fbm(noise) | Texture::Wrinkled(noise) => self.noise(&owner, noise, origin),
            Texture::Marble { noise, scale, variation } => {
                self.noise(&owner, noise, origin);
                self.number(|| format!("the scale of {owner}"), *scale, Range::Finite, origin);
                self.number(|| format!("the variation of {owner}"), *variation, Range::Finite, origin);
            }
            Texture::Image(image) => self.image_texture(&owner, image, origin),
            Texture::Faces(faces) => self.face_texture(&owner, faces, origin),
        }
    }

    fn pair(&mut self, owner: &str, [first, second]: [&SpectrumParam; 2], origin: &Origin) {
        self.spectrum_param(owner, "the first value", first, origin);
        self.spectrum_param(owner, "the second value", second, origin);
    }

    fn image_texture(&mut self, owner: &str, texture: &ImageTexture, origin: &Origin) {
        self.handle("image", texture.image, &self.scene.images, owner, origin);
        self.number(|| format!("the scale of {owner}"), texture.scale, Range::Finite, origin);
        self.mapping(owner, &texture.mapping, origin);
        if let TextureFilter::Ewa { max_anisotropy } = texture.filter
            && !(1.0..=ImageTexture::MOST_ANISOTROPY).contains(&max_anisotropy)
        {
            let message = format!(
                "the anisotropy of {owner} is {max_anisotropy}: expected 1 to {}",
                ImageTexture::MOST_ANISOTROPY
            );
            self.error("bad-number", origin, message);
        }
    }

    fn face_texture(&mut self, owner: &str, texture: &FaceTexture, origin: &Origin) {
        self.number(|| format!("the scale of {owner}"), texture.scale, Range::Finite, origin);
        if let Some(face) = texture.images.first_bad_face() {
            let message = format!(
                "face {face} of {owner} has pixels that are not finite, or refers to what is not there"
            );
            self.error("bad-image", origin, message);
        } else if !texture.images.is_usable() {
            let message = format!("{owner} has no faces, or neither one channel nor three");
            self.error("bad-image", origin, message);
        }
    }

    fn noise(&mut self, owner: &str, noise: &SolidNoise, origin: &Origin) {
        self.number(|| format!("the roughness of {owner}"), noise.roughness, Range::Finite, origin);
        if noise.octaves > SolidNoise::MOST_OCTAVES {
            let message = format!(
                "{owner} has {} octaves of noise: {} is the limit",
                noise.octaves,
                SolidNoise::MOST_OCTAVES
            );
            self.error("bad-number", origin, message);
        }
    }

    fn mapping(&mut self, owner: &str, mapping: &TextureMapping, origin: &Origin) {
        let mut finite = |values: &[f32]| {
            for &value in values {
                self.number(|| format!("the mapping of {owner}"), value, Range::Finite, origin);
            }
        };
        match mapping {
            TextureMapping::Uv(UvMapping { scale, offset }) => {
                finite(scale);
                finite(offset);
            }
            TextureMapping::Planar { s, t, offset, .. } => {
                finite(&<[f32; 3]>::from(*s));
                finite(&<[f32; 3]>::from(*t));
                finite(offset);
            }
            TextureMapping::Spherical { .. } | TextureMapping::Cylindrical { .. } => {}
        }
    }

    /// Finds textures that contain themselves, or too many others in each other. The search keeps its own stack: the
    /// scene may be hostile.
    fn nesting(&mut self) {
        let textures = &self.scene.textures;
        let mut states = vec![State::New; textures.len()];
        let mut stack: Vec<(Handle<Texture>, Vec<Handle<Texture>>)> = Vec::new();
        for (root, _) in textures.iter() {
            if states[root.index()] != State::New {
                continue;
            }
            states[root.index()] = State::Open;
            stack.push((root, textures[root].parts().collect()));
            while let Some((texture, left)) = stack.last_mut() {
                let texture = *texture;
                let Some(part) = left.pop() else {
                    let depth = self.depth(texture, &states);
                    states[texture.index()] = State::Done(depth);
                    stack.pop();
                    continue;
                };
                match states.get(part.index()) {
                    Some(State::New) => {
                        states[part.index()] = State::Open;
                        stack.push((part, textures[part].parts().collect()));
                    }
                    Some(State::Open) => self.cycle(part, &stack),
                    // Done, or a handle that leads nowhere, which has been told.
                    Some(State::Done(_)) | None => {}
                }
            }
        }
    }

    /// How many textures are in each other from `texture` on; complains where the limit is crossed.
    fn depth(&mut self, texture: Handle<Texture>, states: &[State]) -> usize {
        let textures = &self.scene.textures;
        let depth_of = |part: Handle<Texture>| match states.get(part.index()) {
            Some(State::Done(depth)) => *depth,
            _ => 0,
        };
        let depth = 1 + textures[texture].parts().map(depth_of).max().unwrap_or(0);
        if depth == DEEPEST + 1 {
            let origin = textures.origin(texture);
            let message =
                format!("{} holds more than {DEEPEST} textures in each other", called("texture", origin));
            self.error("deep-texture", origin, message);
        }
        depth
    }

    fn cycle(&mut self, again: Handle<Texture>, stack: &[(Handle<Texture>, Vec<Handle<Texture>>)]) {
        const SHOWN: usize = 8;
        let textures = &self.scene.textures;
        let name = |texture: Handle<Texture>| {
            let name = textures.origin(texture).name.as_deref();
            name.map_or_else(|| format!("{texture:?}"), |name| format!("`{name}`"))
        };
        let first = stack.iter().position(|(texture, _)| *texture == again).unwrap_or(0);
        let mut path: Vec<String> =
            stack[first..].iter().take(SHOWN).map(|(texture, _)| name(*texture)).collect();
        if stack.len() - first > SHOWN {
            path.push("...".to_owned());
        }
        path.push(name(again));
        let origin = textures.origin(again);
        let message = format!("{} contains itself: {}", called("texture", origin), path.join(" → "));
        self.error("cyclic-texture", origin, message);
    }
}
