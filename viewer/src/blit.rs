//! Puts a linear picture on a surface: scaled to fit, exposed, sRGB-encoded.
//!
//! In: [`ColorImage`], radiance times `radiance_scale`. Out: the surface's texture. No filter: a texel is a square.

use frame::{Bind, ColorImage, Gpu, GpuError, RasterDesc, RasterKernel, RasterTargets, Recorder};

frame::gpu_struct! {
    /// See `blit.wgsl`.
    pub struct Blit {
        /// Pixels of the surface.
        pub window: [f32; 2],
        /// Pixels of the picture.
        pub picture: [f32; 2],
        /// Times the stored value is 1 on the screen.
        pub exposure: f32,
        /// Uniform structs are multiples of 8 bytes.
        pub _pad: f32,
    }
}

/// The kernel for one surface format.
pub struct Blitter(RasterKernel);

impl Blitter {
    /// Builds it for a surface of this format.
    ///
    /// # Errors
    /// The driver refuses the shader.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Result<Self, GpuError> {
        let encode = if format.is_srgb() { 0.0 } else { 1.0 };
        let kernel = RasterKernel::new(
            gpu,
            &RasterDesc {
                name: "blit",
                sources: &[include_str!("blit.wgsl")],
                entries: ["blit_corner", "blit_texel"],
                bindings: &[Bind::uniform::<Blit>(0, 1, "params"), Bind::texture(2, 0, "in_picture")],
                constants: &[("blit_encode", encode)],
                targets: &[format.into()],
                depth: None,
            },
        )?;
        Ok(Self(kernel))
    }

    /// Draws the picture over the whole surface.
    ///
    /// # Errors
    /// The device was lost.
    pub fn draw(
        &self,
        gpu: &Gpu,
        picture: &ColorImage,
        radiance_scale: f32,
        surface: &wgpu::Texture,
    ) -> Result<(), GpuError> {
        let view = surface.create_view(&Default::default());
        let mut recorder = Recorder::new(gpu);
        let params = recorder.uniform(&Blit {
            window: [surface.width() as f32, surface.height() as f32],
            picture: picture.size().map(|n| n as f32),
            exposure: 1.0 / radiance_scale,
            _pad: 0.0,
        });
        let picture = wgpu::BindingResource::TextureView(picture.texture.view());
        let targets = RasterTargets { colors: &[(&view, Some(wgpu::Color::BLACK))], depth: None };
        recorder.raster("blit", &self.0, &[params.binding(), picture], &targets, 0..3);
        recorder.finish().map(|_| ())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use frame::Room;

    const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

    /// What a window of this size shows of a picture 2 wide and 1 high: linear 0.2158605 left, 1 right.
    fn shown(gpu: &Gpu, size: [u32; 2]) -> Vec<[u8; 4]> {
        let picture = ColorImage::new(gpu, [2, 1]).unwrap();
        // Half floats: 0.2158605 times 2, 2 = a radiance_scale of 2.
        let texels: [[u16; 4]; 2] = [[0x36e8, 0x36e8, 0x36e8, 0x3c00], [0x4000, 0x4000, 0x4000, 0x3c00]];
        let bytes: Vec<u8> = texels.iter().flatten().flat_map(|half| half.to_le_bytes()).collect();
        gpu.queue.write_texture(
            picture.texture.as_image_copy(),
            &bytes,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16), rows_per_image: Some(1) },
            picture.texture.size(),
        );
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let surface = gpu.texture(Room::Frame, "surface", [size[0], size[1], 1], 1, FORMAT, usage).unwrap();
        Blitter::new(gpu, FORMAT).unwrap().draw(gpu, &picture, 2.0, &surface).unwrap();
        gpu.read_texture(&surface).unwrap()
    }

    #[test]
    fn a_picture_fills_the_window_and_keeps_its_aspect() {
        let gpu = match Gpu::new(None) {
            Ok(gpu) => gpu,
            Err(e) => {
                assert!(std::env::var_os("GRIDLIGHT_REQUIRE_ADAPTER").is_none(), "{e}");
                return println!("skipped: {e}");
            }
        };
        let (dark, light, bar) = ([128, 128, 128, 255], [255, 255, 255, 255], [0, 0, 0, 255]);
        assert_eq!(shown(&gpu, [2, 1]), [dark, light]);
        assert_eq!(shown(&gpu, [4, 2]), [[dark, dark, light, light], [dark, dark, light, light]].concat());
        // Too high by half: bars above and below.
        assert_eq!(shown(&gpu, [2, 3]), [[bar, bar], [dark, light], [bar, bar]].concat());
        assert_eq!(shown(&gpu, [4, 1]), [bar, dark, light, bar]);
    }
}
