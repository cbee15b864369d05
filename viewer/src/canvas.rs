//! Draws panels into a window, and what the window shows into a file.
//!
//! Its device is the window's own; see [`crate::worker`] for why it is not the renderer's. [`crate::painter`] calls it from a
//! thread of its own: presenting waits for the screen, on a software adapter for every pixel.

use crate::Failure;
use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use frame::cpu::Image;
use frame::surface::linear_from_srgb;
use frame::{ADAPTER_VARIABLE, Gpu, GpuError, Room};
use std::sync::Arc;
use wgpu::CurrentSurfaceTexture;
use winit::dpi::PhysicalSize;
use winit::window::Window;

/// A window's surface, and what draws into it.
pub struct Canvas {
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    gpu: Gpu,
    renderer: Renderer,
}

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// It is on the screen.
    Yes,
    /// Nobody sees the window.
    Hidden,
    /// Try again.
    Later,
    /// The surface or its device is lost: make another canvas.
    Lost,
}

impl Canvas {
    /// Opens a device that can draw into the window.
    pub fn new(window: &Arc<Window>, adapter: Option<&str>) -> Result<Self, Failure> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let surface = instance.create_surface(window.clone())?;
        let adapter = choose(&instance, &surface, adapter)?;
        let gpu = Gpu::from_adapter(&adapter)?;
        gpu.device.on_uncaptured_error(Arc::new(|e| eprintln!("warning: {e}")));
        let size = window.inner_size();
        let mut config = surface
            .get_default_config(&adapter, size.width.max(1), size.height.max(1))
            .ok_or("the adapter cannot draw into this window")?;
        // A target that stores what it is given is what user interfaces want.
        if let Some(plain) = surface.get_capabilities(&adapter).formats.into_iter().find(|f| !f.is_srgb()) {
            config.format = plain;
        }
        surface.configure(&gpu.device, &config);
        let renderer = Renderer::new(&gpu.device, config.format, RendererOptions::default());
        Ok(Self { surface, config, gpu, renderer })
    }

    /// Longest side of a picture that can be shown.
    pub fn largest_side(&self) -> usize {
        self.gpu.device.limits().max_texture_dimension_2d as usize
    }

    /// The window has another size.
    pub fn resize(&mut self, size: PhysicalSize<u32>) {
        // A minimised window has no pixels, and a surface must have one.
        let largest = self.largest_side() as u32;
        [self.config.width, self.config.height] =
            [size.width.clamp(1, largest), size.height.clamp(1, largest)];
        self.surface.configure(&self.gpu.device, &self.config);
    }

    /// Takes over new and changed pictures, which happens whether or not anything is drawn.
    pub fn take_textures(&mut self, delta: &mut egui::TexturesDelta) {
        for (id, deltas) in delta.set.drain() {
            for delta in deltas {
                self.renderer.update_texture(&self.gpu.device, &self.gpu.queue, id, &delta);
            }
        }
    }

    /// Forgets pictures that are no longer shown; after drawing.
    pub fn free_textures(&mut self, delta: &mut egui::TexturesDelta) {
        for id in delta.free.drain() {
            self.renderer.free_texture(&id);
        }
    }

    /// Draws into the window.
    pub fn draw(&mut self, shapes: &[egui::ClippedPrimitive], pixels_per_point: f32) -> Shown {
        let texture = match self.surface.get_current_texture() {
            CurrentSurfaceTexture::Success(texture) | CurrentSurfaceTexture::Suboptimal(texture) => texture,
            // Nobody sees it; the system asks again when somebody does.
            CurrentSurfaceTexture::Occluded => return Shown::Hidden,
            CurrentSurfaceTexture::Timeout => return Shown::Later,
            CurrentSurfaceTexture::Outdated => {
                self.surface.configure(&self.gpu.device, &self.config);
                return Shown::Later;
            }
            CurrentSurfaceTexture::Lost | CurrentSurfaceTexture::Validation => return Shown::Lost,
        };
        let view = texture.texture.create_view(&Default::default());
        self.draw_into(&view, shapes, pixels_per_point);
        self.gpu.queue.present(texture);
        Shown::Yes
    }

    /// Draws the same into a picture: linear, as picture files are written from.
    ///
    /// # Errors
    /// Out of memory, or the device was lost.
    pub fn screenshot(
        &mut self,
        shapes: &[egui::ClippedPrimitive],
        pixels_per_point: f32,
    ) -> Result<Image<[f32; 3]>, GpuError> {
        let size = [self.config.width, self.config.height];
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let [width, height] = size;
        let target =
            self.gpu.texture(Room::Frame, "screenshot", [width, height, 1], 1, self.config.format, usage)?;
        self.draw_into(target.view(), shapes, pixels_per_point);
        let is_bgra = format!("{:?}", self.config.format).starts_with("Bgra");
        let texels: Vec<[u8; 4]> = self.gpu.read_texture(&target)?;
        Ok(Image::from_fn(size, |x, y| {
            let [first, g, third, _] = texels[(y * width + x) as usize];
            let [r, b] = if is_bgra { [third, first] } else { [first, third] };
            [r, g, b].map(|code| linear_from_srgb(f32::from(code) / 255.0))
        }))
    }

    fn draw_into(
        &mut self,
        view: &wgpu::TextureView,
        shapes: &[egui::ClippedPrimitive],
        pixels_per_point: f32,
    ) {
        let screen =
            ScreenDescriptor { size_in_pixels: [self.config.width, self.config.height], pixels_per_point };
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let before = self.renderer.update_buffers(device, queue, &mut encoder, shapes, &screen);
        let mut recording = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("panels"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            })
            .forget_lifetime();
        self.renderer.render(&mut recording, shapes, &screen);
        drop(recording);
        queue.submit(before.into_iter().chain([encoder.finish()]));
    }
}

/// An adapter that can draw into the surface: the named one, or the one wgpu would take.
fn choose(
    instance: &wgpu::Instance,
    surface: &wgpu::Surface<'_>,
    name: Option<&str>,
) -> Result<wgpu::Adapter, GpuError> {
    let wanted = name.map(str::to_owned).or_else(|| std::env::var(ADAPTER_VARIABLE).ok()).unwrap_or_default();
    let mut fitting: Vec<_> = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY))
        .into_iter()
        .filter(|adapter| adapter.is_surface_supported(surface))
        .collect();
    let found = fitting.iter().map(|a| a.get_info().name).collect::<Vec<_>>().join(", ");
    fitting.retain(|a| a.get_info().name.to_lowercase().contains(&wanted.to_lowercase()));
    // The software adapter only where there is nothing else.
    fitting.sort_by_key(|adapter| adapter.get_info().device_type == wgpu::DeviceType::Cpu);
    let wanted = if wanted.is_empty() { String::new() } else { format!(" named \"{wanted}\"") };
    fitting
        .into_iter()
        .next()
        .ok_or_else(|| GpuError::NoAdapter { wanted: format!("{wanted} that draws into windows"), found })
}
