//! From the textures of a scene description to nodes.

use std::collections::BTreeMap;
use std::sync::Arc;

use sahl_image::{Image, Pixels};
use sahl_math::Vec3;
use sahl_scene::{
    Diagnostic, Diagnostics, FaceImages, FaceTexture, FloatParam, Handle, ImageTexture, SceneDesc, Span,
    SpectrumParam, Texture, TextureFilter,
};

use super::faces::{FaceNode, Pyramid};
use super::image::{self, ImageNode};
use super::mapping::Mapping;
use super::solid::SolidNode;
use super::{ConstantNode, FloatSource, Node, SpectrumSource, TextureId, Textures, pyramid};
use crate::spectrum::{ColorRole, SpectralCurve, Spectrum, Wavelengths};

/// Textures may be nested this deep, which bounds the stack.
const MAX_DEPTH: u32 = 64;
/// A texture may evaluate this many others, which bounds the time: sharing can make a shallow graph exponential.
const MAX_EVALUATIONS: u32 = 4096;

/// What one evaluation of a texture takes.
#[derive(Clone, Copy, Debug, Default)]
struct Cost {
    depth: u32,
    evaluations: u32,
}

impl Cost {
    fn of_parent(children: impl IntoIterator<Item = Cost>) -> Cost {
        let mut cost = Cost { depth: 0, evaluations: 1 };
        for child in children {
            cost.depth = cost.depth.max(child.depth);
            cost.evaluations = cost.evaluations.saturating_add(child.evaluations);
        }
        cost.depth += 1;
        cost
    }
}

/// How far a texture of the scene is.
#[derive(Clone, Copy, Debug)]
enum State {
    Untouched,
    /// Its children are being compiled.
    Open,
    Done(TextureId, Cost),
}

struct Compiler<'a> {
    scene: &'a SceneDesc,
    textures: Textures,
    states: Vec<State>,
    /// The sizes of images that filters ask for, by the image's index.
    pyramids: BTreeMap<usize, Box<[Arc<Image>]>>,
    /// The smaller sizes of images of faces.
    face_pyramids: Vec<(Arc<FaceImages>, Arc<Pyramid>)>,
    diagnostics: &'a mut Diagnostics,
}

impl Textures {
    /// Compiles the textures of `scene`.
    ///
    /// A texture that refers to itself, to something missing, or to too many others is reported as an error and is
    /// black.
    pub fn new(scene: &SceneDesc, diagnostics: &mut Diagnostics) -> Self {
        let states = vec![State::Untouched; scene.textures.len()];
        let mut compiler = Compiler {
            scene,
            textures: Self::default(),
            states,
            pyramids: BTreeMap::new(),
            face_pyramids: Vec::new(),
            diagnostics,
        };
        for (handle, _) in scene.textures.iter() {
            compiler.compile(handle);
        }
        compiler.textures.resolved = compiler.states.iter().map(State::id).collect();
        compiler.textures
    }

    /// What a parameter of the scene refers to. A texture that does not exist is zero: compiling reports it.
    pub fn float_source(&self, param: &FloatParam) -> FloatSource {
        match *param {
            FloatParam::Constant(value) => FloatSource::Constant(value),
            FloatParam::Texture(handle) => match self.resolved.get(handle.index()) {
                Some(&id) => self.fold_float(id),
                None => FloatSource::Constant(0.0),
            },
        }
    }

    /// What a parameter of the scene refers to, for a certain role. A texture that does not exist is zero.
    ///
    /// `span` is what messages about a constant point at.
    pub fn spectrum_source(
        &self,
        param: &SpectrumParam,
        role: ColorRole,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> SpectrumSource {
        match param {
            SpectrumParam::Constant(spectrum) => {
                SpectrumSource::Constant(SpectralCurve::new(spectrum, role, span, diagnostics))
            }
            SpectrumParam::Texture(handle) => match self.resolved.get(handle.index()) {
                Some(&id) => match &self.nodes[id.0 as usize] {
                    Node::Constant(constant) => SpectrumSource::Constant(constant.curve(role).clone()),
                    _ => SpectrumSource::Texture(id, role),
                },
                None => SpectrumSource::Constant(SpectralCurve::constant(0.0)),
            },
        }
    }

    fn fold_float(&self, id: TextureId) -> FloatSource {
        match &self.nodes[id.0 as usize] {
            Node::Constant(constant) => FloatSource::Constant(constant.float),
            _ => FloatSource::Texture(id),
        }
    }
}

impl State {
    /// The node, once done.
    fn id(&self) -> TextureId {
        match self {
            State::Done(id, _) => *id,
            State::Untouched | State::Open => unreachable!("every texture has been compiled"),
        }
    }
}

impl Compiler<'_> {
    /// Compiles `root` after what it refers to; with a stack of its own, however deep the scene nests.
    fn compile(&mut self, root: Handle<Texture>) {
        let mut stack = vec![root];
        while let Some(&handle) = stack.last() {
            match self.states[handle.index()] {
                State::Done(..) => {
                    stack.pop();
                }
                State::Untouched => {
                    self.states[handle.index()] = State::Open;
                    for child in self.scene.textures[handle].parts() {
                        match self.states.get(child.index()) {
                            Some(State::Untouched) => stack.push(child),
                            Some(State::Done(..)) => {}
                            Some(State::Open) => {
                                self.reject(handle, "texture-cycle", "refers to itself");
                                break;
                            }
                            None => {
                                self.reject(
                                    handle,
                                    "missing-texture",
                                    "refers to a texture that does not exist",
                                );
                                break;
                            }
                        }
                    }
                }
                State::Open => {
                    stack.pop();
                    self.finish(handle);
                }
            }
        }
    }

    /// Reports what is wrong with a texture, and makes it black.
    fn reject(&mut self, handle: Handle<Texture>, code: &'static str, what: &str) {
        let origin = self.scene.textures.origin(handle);
        let name = origin.name.as_deref().map_or(String::new(), |name| format!(" `{name}`"));
        self.diagnostics.push(Diagnostic::error(code, origin.span, format!("the texture{name} {what}")));
        let black = self.push(Node::Constant(black()));
        self.states[handle.index()] = State::Done(black, Cost::of_parent([]));
    }

    /// Makes the node of a texture whose children are done.
    fn finish(&mut self, handle: Handle<Texture>) {
        let texture = &self.scene.textures[handle];
        let cost = Cost::of_parent(texture.parts().map(|child| match self.states.get(child.index()) {
            Some(State::Done(_, cost)) => *cost,
            _ => Cost::default(),
        }));
        if cost.depth > MAX_DEPTH {
            return self.reject(handle, "texture-too-deep", &format!("is nested more than {MAX_DEPTH} deep"));
        }
        if cost.evaluations > MAX_EVALUATIONS {
            let what = format!("evaluates more than {MAX_EVALUATIONS} others");
            return self.reject(handle, "texture-too-large", &what);
        }
        let Some(node) = self.node(texture, self.scene.textures.origin(handle).span) else {
            return self.reject(handle, "missing-image", "has no image, or one without pixels");
        };
        let id = self.push(node);
        self.states[handle.index()] = State::Done(id, cost);
    }

    /// The node of a texture whose children are done; `None` if its image is missing.
    fn node(&mut self, texture: &Texture, span: Option<Span>) -> Option<Node> {
        self.textures.needs_footprint |=
            matches!(texture, Texture::Checkerboard { .. } | Texture::SolidCheckerboard { .. });
        let mut child = |param: &SpectrumParam| self.spectrum_child(param, span);
        Some(match texture {
            Texture::Constant(spectrum) => Node::Constant(constant(spectrum, span, self.diagnostics)),
            Texture::Scale { texture, scale } => {
                Node::Scale { texture: child(texture), scale: self.float_child(scale) }
            }
            Texture::Mix { first, second, amount } => {
                let (first, second) = (child(first), child(second));
                Node::Mix { first, second, amount: self.float_child(amount) }
            }
            Texture::DirectionMix { first, second, direction } => Node::DirectionMix {
                first: child(first),
                second: child(second),
                direction: direction.try_normalize().unwrap_or(Vec3::ZERO),
            },
            Texture::Bilerp { mapping, corners } => {
                Node::Bilerp { mapping: Mapping::new(mapping), corners: corners.each_ref().map(child) }
            }
            Texture::Checkerboard { mapping, even, odd } => {
                Node::Checkerboard { mapping: Mapping::new(mapping), even: child(even), odd: child(odd) }
            }
            Texture::SolidCheckerboard { world_to_texture, even, odd } => Node::SolidCheckerboard {
                to_texture: Box::new(*world_to_texture),
                even: child(even),
                odd: child(odd),
            },
            Texture::Dots { mapping, inside, outside } => {
                Node::Dots { mapping: Mapping::new(mapping), inside: child(inside), outside: child(outside) }
            }
            Texture::Fbm(noise) => self.solid(SolidNode::fbm(noise)),
            Texture::Wrinkled(noise) => self.solid(SolidNode::wrinkled(noise)),
            Texture::Windy { world_to_texture } => self.solid(SolidNode::windy(world_to_texture)),
            Texture::Marble { noise, scale, variation } => {
                self.solid(SolidNode::marble(noise, *scale, *variation))
            }
            Texture::Image(texture) => Node::Image(self.image(texture)?),
            Texture::Faces(texture) => Node::Faces(self.faces(texture)?),
        })
    }

    /// Noise leaves out what is finer than the footprint.
    fn solid(&mut self, node: SolidNode) -> Node {
        self.textures.needs_footprint = true;
        Node::Solid(Box::new(node))
    }

    /// Textures of the same images share their smaller sizes.
    fn faces(&mut self, texture: &FaceTexture) -> Option<FaceNode> {
        self.textures.needs_footprint = true;
        self.textures.needs_face = true;
        let known = self.face_pyramids.iter().find(|(images, _)| Arc::ptr_eq(images, &texture.images));
        if let Some((_, pyramid)) = known {
            return Some(FaceNode::new(texture, Arc::clone(pyramid)));
        }
        let pyramid = Arc::new(Pyramid::new(&texture.images)?);
        self.textures.pyramid_bytes += pyramid.bytes() + texture.images.texels.bytes() as u64;
        self.face_pyramids.push((Arc::clone(&texture.images), Arc::clone(&pyramid)));
        Some(FaceNode::new(texture, pyramid))
    }

    fn image(&mut self, texture: &ImageTexture) -> Option<ImageNode> {
        let image = self.scene.images.get(texture.image)?;
        if !image::is_usable(image) {
            return None;
        }
        let levels = match texture.filter {
            TextureFilter::Nearest | TextureFilter::Bilinear => Box::new([Arc::clone(image)]) as Box<[_]>,
            TextureFilter::Trilinear | TextureFilter::Ewa { .. } => {
                self.textures.needs_footprint = true;
                self.levels(texture.image, image)
            }
        };
        ImageNode::new(texture, levels)
    }

    /// The sizes of an image, made once for all textures that ask for them.
    fn levels(&mut self, handle: Handle<Arc<Image>>, image: &Arc<Image>) -> Box<[Arc<Image>]> {
        if let Some(levels) = self.pyramids.get(&handle.index()) {
            return levels.clone();
        }
        let levels = pyramid::levels(image);
        let bytes = |image: &Arc<Image>| match &image.pixels {
            Pixels::U8(values) => values.len(),
            Pixels::F32(values) => size_of_val(values.as_slice()),
        };
        self.textures.pyramid_bytes += levels[1..].iter().map(|image| bytes(image) as u64).sum::<u64>();
        self.pyramids.insert(handle.index(), levels.clone());
        levels
    }

    fn push(&mut self, node: Node) -> TextureId {
        let id = u32::try_from(self.textures.nodes.len())
            .expect("a scene has fewer than 2^32 textures and constants");
        self.textures.nodes.push(node);
        TextureId(id)
    }

    fn spectrum_child(&mut self, param: &SpectrumParam, span: Option<Span>) -> TextureId {
        match param {
            SpectrumParam::Constant(spectrum) => {
                let node = Node::Constant(constant(spectrum, span, self.diagnostics));
                self.push(node)
            }
            SpectrumParam::Texture(handle) => self.states[handle.index()].id(),
        }
    }

    fn float_child(&self, param: &FloatParam) -> FloatSource {
        match *param {
            FloatParam::Constant(value) => FloatSource::Constant(value),
            FloatParam::Texture(handle) => self.textures.fold_float(self.states[handle.index()].id()),
        }
    }
}

fn black() -> ConstantNode {
    let zero = SpectralCurve::constant(0.0);
    ConstantNode { float: 0.0, albedo: zero.clone(), unbounded: zero.clone(), illuminant: zero }
}

/// A constant as each role sees it. Messages are those of a reflectance, the most frequent one.
fn constant(
    spectrum: &sahl_scene::Spectrum,
    span: Option<Span>,
    diagnostics: &mut Diagnostics,
) -> ConstantNode {
    let albedo = SpectralCurve::new(spectrum, ColorRole::Albedo, span, diagnostics);
    let mut repeated = Diagnostics::default();
    let mut curve = |role| SpectralCurve::new(spectrum, role, span, &mut repeated);
    let (unbounded, illuminant) = (curve(ColorRole::Unbounded), curve(ColorRole::Illuminant));
    let float = match spectrum {
        sahl_scene::Spectrum::Constant(value) => *value,
        sahl_scene::Spectrum::Rgb { rgb, .. } => rgb[0],
        _ => Spectrum::lanes(unbounded.at(&Wavelengths::Rgb))[0],
    };
    ConstantNode { float, albedo, unbounded, illuminant }
}
