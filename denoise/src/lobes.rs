//! What the passes of every filter here share: pictures of both lobes, kernels with the common sources, chains of passes.
//!
//! A binding cannot be left empty: without a specular lobe, one texel stands in that nothing is stored to and nobody
//! reads.

use crate::{edge, light};
use frame::{
    Bind, Gpu, GpuError, HALF_WGSL, Kernel, KernelDesc, RadianceImage, Recorder, Room, Texture, brdf, info,
    surface,
};
use wgpu::{TextureFormat, TextureUsages};

/// Of every kernel here.
pub const WORKGROUP: [u32; 3] = [8, 8, 1];

/// Groups of [`WORKGROUP`] that cover a picture.
pub fn workgroups([width, height]: [u32; 2]) -> [u32; 3] {
    [width.div_ceil(WORKGROUP[0]), height.div_ceil(WORKGROUP[1]), 1]
}

/// A kernel whose last sources follow everything that is shared.
///
/// # Errors
/// It was refused.
pub fn kernel(
    gpu: &Gpu,
    name: &str,
    entry: &str,
    last: &[&str],
    bindings: &[Bind],
    constants: &[(&str, f64)],
) -> Result<Kernel, GpuError> {
    let shared = [info::WGSL, surface::WGSL, brdf::WGSL, HALF_WGSL, light::WGSL, edge::WGSL];
    let sources: Vec<&str> = shared.iter().chain(last).copied().collect();
    let desc = KernelDesc { name, sources: &sources, entry, workgroup: WORKGROUP, bindings, constants };
    Ok(Kernel::new(gpu, &desc)?)
}

/// A picture that kernels read and write.
///
/// # Errors
/// Too large, or out of memory.
pub fn picture(
    gpu: &Gpu,
    room: Room,
    label: &str,
    [width, height]: [u32; 2],
    format: TextureFormat,
) -> Result<Texture, GpuError> {
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
    gpu.texture(room, label, [width, height, 1], 1, format, usage | TextureUsages::COPY_DST)
}

/// Diffuse and specular light.
///
/// # Errors
/// Too large, or out of memory.
pub fn pair(
    gpu: &Gpu,
    room: Room,
    label: &str,
    size: [u32; 2],
    has_specular: bool,
) -> Result<[Texture; 2], GpuError> {
    pair_as(gpu, room, label, size, has_specular, RadianceImage::FORMAT)
}

/// The same in another format.
///
/// # Errors
/// Too large, or out of memory.
pub fn pair_as(
    gpu: &Gpu,
    room: Room,
    label: &str,
    size: [u32; 2],
    has_specular: bool,
    format: TextureFormat,
) -> Result<[Texture; 2], GpuError> {
    let lobe = |size| picture(gpu, room, label, size, format);
    Ok([lobe(size)?, lobe(if has_specular { size } else { [1, 1] })?])
}

/// Both lobes of what came in; the diffuse one stands in for a missing specular one.
pub fn of(noisy: &RadianceImage) -> [&Texture; 2] {
    [&noisy.diffuse, noisy.specular.as_ref().unwrap_or(&noisy.diffuse)]
}

/// Two pictures written in turn.
pub struct Turns([[Texture; 2]; 2]);

impl Turns {
    /// Allocates both.
    ///
    /// # Errors
    /// Too large, or out of memory.
    pub fn new(gpu: &Gpu, label: &str, size: [u32; 2], has_specular: bool) -> Result<Self, GpuError> {
        let pair = || pair(gpu, Room::Radiance, label, size, has_specular);
        Ok(Self([pair()?, pair()?]))
    }

    /// What pass number `turn` writes.
    pub fn output(&self, turn: usize) -> [&Texture; 2] {
        self.0[turn % 2].each_ref()
    }

    /// Records passes 0..`count`, each of which reads what the one before it wrote, and returns the last one's output.
    /// Where `first` is one of the two itself, `start` is the turn after the one that wrote it.
    pub fn chain<'a>(
        &'a self,
        first: [&'a Texture; 2],
        start: usize,
        count: usize,
        mut pass: impl FnMut(usize, [&'a Texture; 2], [&'a Texture; 2]),
    ) -> [&'a Texture; 2] {
        (0..count).fold(first, |input, index| {
            let output = self.output(start + index);
            pass(index, input, output);
            output
        })
    }
}

/// What a denoiser hands on, noted under `denoise/NAME` to be looked at.
pub fn clean(
    recorder: &mut Recorder<'_>,
    name: &str,
    noisy: &RadianceImage,
    [diffuse, specular]: [&Texture; 2],
) -> RadianceImage {
    let clean = RadianceImage {
        diffuse: diffuse.clone(),
        specular: noisy.specular.is_some().then(|| specular.clone()),
        samples: noisy.samples.clone(),
    };
    recorder.output(&format!("denoise/{name}/diffuse"), &clean.diffuse);
    if let Some(specular) = &clean.specular {
        recorder.output(&format!("denoise/{name}/specular"), specular);
    }
    clean
}
