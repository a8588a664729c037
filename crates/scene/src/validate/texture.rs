//! Textures, which may refer to each other.

use super::{Check, Range, called};
use crate::{FloatParam, Handle, SpectrumParam, Texture};

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
                self.spectrum_param(&owner, "the first value", first, origin);
                self.spectrum_param(&owner, "the second value", second, origin);
                self.float_param(&owner, "the amount", *amount, Range::Finite, origin);
            }
            Texture::Checkerboard { mapping, even, odd } => {
                self.spectrum_param(&owner, "the value", even, origin);
                self.spectrum_param(&owner, "the value", odd, origin);
                self.mapping(&owner, mapping.scale.iter().chain(&mapping.offset).copied(), handle);
            }
            Texture::Image(image) => {
                self.handle("image", image.image, &scene.images, &owner, origin);
                self.number(|| format!("the scale of {owner}"), image.scale, Range::Finite, origin);
                let mapping = &image.mapping;
                self.mapping(&owner, mapping.scale.iter().chain(&mapping.offset).copied(), handle);
            }
        }
    }

    fn mapping(&mut self, owner: &str, values: impl Iterator<Item = f32>, handle: Handle<Texture>) {
        let origin = self.scene.textures.origin(handle);
        for value in values {
            self.number(|| format!("the mapping of {owner}"), value, Range::Finite, origin);
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
            stack.push((root, parts(&textures[root])));
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
                        stack.push((part, parts(&textures[part])));
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
        let depth = 1 + parts(&textures[texture]).into_iter().map(depth_of).max().unwrap_or(0);
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

/// The textures that a texture refers to.
fn parts(texture: &Texture) -> Vec<Handle<Texture>> {
    let spectrum = |param: &SpectrumParam| match param {
        SpectrumParam::Texture(handle) => Some(*handle),
        SpectrumParam::Constant(_) => None,
    };
    let float = |param: &FloatParam| match param {
        FloatParam::Texture(handle) => Some(*handle),
        FloatParam::Constant(_) => None,
    };
    let parts = match texture {
        Texture::Constant(_) | Texture::Image(_) => [None; 3],
        Texture::Scale { texture, scale } => [spectrum(texture), float(scale), None],
        Texture::Mix { first, second, amount } => [spectrum(first), spectrum(second), float(amount)],
        Texture::Checkerboard { even, odd, .. } => [spectrum(even), spectrum(odd), None],
    };
    parts.into_iter().flatten().collect()
}
