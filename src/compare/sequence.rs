//! A sequence of frames, watched: what flickers, and how soon what was uncovered is as good as the rest.
//!
//! In: the pictures of one configuration, frame by frame, with the G-buffers of the display, and two independent references
//! of every frame by the same tracer (none where everything stands still: a reference does not change then). Out: the
//! figures of [`Temporal`] and [`Recovery`].
//!
//! A pixel shows what another showed a frame ago if its motion points into the picture, at the same object, within 1 % of
//! its depth of the plane it lies in: the tests that filters over time make.

use super::Color;
use crate::metrics::{Consecutive, Recovery, Temporal, origin};
use crate::pipeline::Rendered;
use crate::{Error, output};
use frame::cpu::Image;
use frame::surface::face_normal_unpack;
use frame::{FrameInfo, Gpu};
use glam::{Vec2, Vec3};
use half::f16;

/// What of a surface's depth its plane may be off.
const PLANE: f32 = 0.01;

/// What the display saw in one frame.
struct Seen {
    color: Color,
    frame: FrameInfo,
    distance: Image<f32>,
    face_normal: Image<u32>,
    motion: Image<[f32; 2]>,
    /// Object + 1, 0 = nothing.
    object: Image<u32>,
}

/// Two independent references of one frame.
pub type Pair = [Color; 2];

/// A sequence so far.
pub struct Sequence<'a> {
    /// By frame; empty where everything stands still.
    references: &'a [Pair],
    last: Option<Seen>,
    index: usize,
    temporal: Temporal,
    recovery: Recovery,
}

impl<'a> Sequence<'a> {
    /// Nothing seen yet.
    pub fn new(references: &'a [Pair]) -> Self {
        Self {
            references,
            last: None,
            index: 0,
            temporal: Temporal::default(),
            recovery: Recovery::default(),
        }
    }

    /// Adds the next frame. One beyond the last reference is not looked at, and neither is a picture that holds what is no
    /// number.
    ///
    /// # Errors
    /// Reading back fails.
    pub fn add(&mut self, gpu: &Gpu, rendered: &Rendered) -> Result<(), Error> {
        let this = Seen::of(gpu, rendered)?;
        let was = match &self.last {
            Some(last) => this.origins(last),
            None => Image::filled(this.color.size(), None),
        };
        let flat = [&this.color; 2];
        let pair = match self.references.get(self.index) {
            Some([a, b]) => [a, b],
            // A reference that does not change says nothing but that.
            None if self.references.is_empty() => flat,
            None => return Ok(()),
        };
        if let Some(last) = &self.last {
            let before = match self.index.checked_sub(1).and_then(|i| self.references.get(i)) {
                Some([a, b]) => [a, b],
                None => flat,
            };
            let steps = [0, 1].map(|i| Consecutive { last: before[i], this: pair[i] });
            // All have the display's size, and it has pixels.
            let _ = self.temporal.add(steps, Consecutive { last: &last.color, this: &this.color }, &was);
        }
        if !self.references.is_empty() {
            let hit = this.object.map(|object| object > 0);
            let _ = self.recovery.add(pair, &this.color, &hit, &was);
        }
        self.last = Some(this);
        self.index += 1;
        Ok(())
    }

    /// Error of the change from frame to frame, W / (sr m^2); none of fewer than two frames.
    pub fn temporal(&self) -> Option<f64> {
        self.temporal.error().filter(|error| error.is_finite())
    }

    /// As [`Recovery::ratio`].
    pub fn uncovered(&self) -> Option<f64> {
        self.recovery.ratio().filter(|ratio| ratio.is_finite())
    }
}

impl Seen {
    fn of(gpu: &Gpu, rendered: &Rendered) -> Result<Self, Error> {
        let size = rendered.display.size();
        let [width, _] = size;
        // One texel per pixel by construction of the read-back.
        fn picture<T: Copy>(size: [u32; 2], width: u32, texels: &[T]) -> Image<T> {
            Image::from_fn(size, |x, y| texels[(y * width + x) as usize])
        }
        let motion_id: Vec<[u32; 2]> = gpu.read_texture(&rendered.display.motion_id)?;
        let motion_id = picture(size, width, &motion_id);
        let half = |bits: u32| f16::from_bits(bits as u16).to_f32();
        let still = rendered.trace.size() != size;
        let mut frame = FrameInfo { trace_size: size, ..rendered.frame.clone() };
        if still {
            frame.jitter = [0.0; 2];
        }
        Ok(Self {
            color: output::color(gpu, &rendered.color, rendered.frame.radiance_scale)?,
            distance: picture(size, width, &gpu.read_texture::<f32>(&rendered.display.distance)?),
            face_normal: picture(size, width, &gpu.read_texture::<u32>(&rendered.display.face_normal)?),
            motion: motion_id.map(|[xy, _]| [half(xy), half(xy >> 16)]),
            object: motion_id.map(|[_, id]| id & 0x7fff_ffff),
            frame,
        })
    }

    /// Where each pixel's surface lay in the last frame, if it was seen there.
    fn origins(&self, last: &Self) -> Image<Option<[i32; 2]>> {
        Image::from_fn(self.color.size(), |x, y| self.origin_of([x as i32, y as i32], last))
    }

    fn origin_of(&self, at: [i32; 2], last: &Self) -> Option<[i32; 2]> {
        let object = self.object.get(at[0], at[1])?;
        let motion = self.motion.get(at[0], at[1])?;
        let was = origin(at, motion);
        if object == 0 || last.object.get(was[0], was[1])? != object {
            return None;
        }
        // Where the surface was: on the ray that its motion tells, as deep as it is if it stands still.
        let here = self.position(at)?;
        let view = last.frame.uniform();
        let (forward, eye) = (Vec3::from(view.forward), Vec3::from(view.eye));
        let depth = forward.dot(here - eye);
        let exact = Vec2::from(at.map(|side| side as f32)) - Vec2::from(motion);
        let ray = last.ray(exact);
        let there = eye + ray * (depth / forward.dot(ray).max(1e-6));
        let normal = face_normal_unpack(self.face_normal.get(at[0], at[1])?);
        let off = normal.dot(last.position(was)? - there).abs();
        (off <= PLANE * depth).then_some(was)
    }

    /// World space, metres.
    fn position(&self, at: [i32; 2]) -> Option<Vec3> {
        let distance = self.distance.get(at[0], at[1])?;
        Some(Vec3::from(self.frame.uniform().eye) + distance * self.ray(Vec2::from(at.map(|s| s as f32))))
    }

    /// Unit direction through a pixel, whose centres lie at whole numbers.
    fn ray(&self, pixel: Vec2) -> Vec3 {
        let view = self.frame.uniform();
        let size = Vec2::from(self.frame.trace_size.map(|side| side as f32));
        let point = pixel + 0.5 + Vec2::from(self.frame.jitter);
        let ndc = point / size * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0);
        let [forward, right, up] = [view.forward, view.right, view.up].map(Vec3::from);
        (forward + ndc.x * right + ndc.y * up).normalize()
    }
}
