//! The window's life: opened once, drawn when asked, closed by its user or after a number of frames.

use crate::Failure;
use crate::blit::Blitter;
use frame::{ADAPTER_VARIABLE, Gpu, GpuError};
use gridlight::pipeline::{Pipeline, Rendered};
use gridlight::{Progress, RenderSettings};
use std::sync::Arc;
use wgpu::CurrentSurfaceTexture;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::{Window, WindowId};

/// Opens a window and shows pictures until it is closed, or until `frames` of them were shown.
pub fn run(settings: RenderSettings, adapter: Option<String>, frames: Option<u32>) -> Result<(), Failure> {
    let mut viewer = Viewer { settings, adapter, frames_left: frames, screen: None, failure: None };
    EventLoop::new()?.run_app(&mut viewer)?;
    match viewer.failure {
        Some(failure) => Err(failure),
        None => Ok(()),
    }
}

/// What the event loop owns.
struct Viewer {
    settings: RenderSettings,
    adapter: Option<String>,
    frames_left: Option<u32>,
    screen: Option<Screen>,
    failure: Option<Failure>,
}

/// The window, what draws into it, and the last picture.
struct Screen {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    blitter: Blitter,
    pipeline: Pipeline,
    picture: Option<Rendered>,
}

impl ApplicationHandler for Viewer {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.screen.is_none() {
            match Screen::open(event_loop, &self.settings, self.adapter.as_deref()) {
                Ok(screen) => self.screen = Some(screen),
                Err(failure) => self.end(event_loop, Some(failure)),
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(screen) = &mut self.screen else { return };
        match event {
            WindowEvent::CloseRequested => self.end(event_loop, None),
            WindowEvent::Resized(size) => screen.resize(size),
            WindowEvent::RedrawRequested => {
                // Counted frames are all rendered; otherwise a picture of what stands still is good until it moves.
                let again = self.frames_left.is_some() || screen.moves();
                match screen.draw(again) {
                    Ok(shown) => self.frames_left = self.frames_left.map(|n| n - u32::from(shown)),
                    Err(failure) => return self.end(event_loop, Some(failure)),
                }
                match self.frames_left {
                    Some(0) => self.end(event_loop, None),
                    _ if again => screen.window.request_redraw(),
                    _ => {}
                }
            }
            _ => {}
        }
    }
}

impl Viewer {
    fn end(&mut self, event_loop: &ActiveEventLoop, failure: Option<Failure>) {
        // The surface goes before the window that it belongs to.
        self.screen = None;
        self.failure = failure;
        event_loop.exit();
    }
}

impl Screen {
    fn open(
        event_loop: &ActiveEventLoop,
        settings: &RenderSettings,
        adapter: Option<&str>,
    ) -> Result<Self, Failure> {
        let [width, height] = settings.display_size;
        let attributes = Window::default_attributes()
            .with_title(format!("gridlight: {}", settings.scene))
            .with_inner_size(PhysicalSize::new(width, height));
        let window = Arc::new(event_loop.create_window(attributes)?);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let surface = instance.create_surface(window.clone())?;
        let adapter = choose(&instance, &surface, adapter)?;
        let gpu = Gpu::from_adapter(&adapter)?;
        let size = window.inner_size();
        let mut config = surface
            .get_default_config(&adapter, size.width.max(1), size.height.max(1))
            .ok_or("the adapter cannot draw into this window")?;
        // A target that stores what it is given is what user interfaces want, too.
        if let Some(plain) = surface.get_capabilities(&adapter).formats.into_iter().find(|f| !f.is_srgb()) {
            config.format = plain;
        }
        surface.configure(&gpu.device, &config);
        let blitter = Blitter::new(&gpu, config.format)?;
        let pipeline = Pipeline::new(gpu, settings, Progress::default())?;
        for warning in pipeline.warnings() {
            eprintln!("warning: {warning}");
        }
        window.request_redraw();
        Ok(Self { window, surface, config, blitter, pipeline, picture: None })
    }

    /// Whether the next picture differs from the last.
    fn moves(&self) -> bool {
        self.pipeline.scene().needs().motion
    }

    fn resize(&mut self, size: PhysicalSize<u32>) {
        // A minimised window has no pixels, and a surface must have one.
        [self.config.width, self.config.height] = [size.width.max(1), size.height.max(1)];
        self.configure();
        self.window.request_redraw();
    }

    fn configure(&self) {
        self.surface.configure(&self.pipeline.gpu().device, &self.config);
    }

    /// Renders if `again` or for the first time, and shows. False if the surface had no texture to give right now.
    fn draw(&mut self, again: bool) -> Result<bool, Failure> {
        let texture = match self.surface.get_current_texture() {
            CurrentSurfaceTexture::Success(texture) | CurrentSurfaceTexture::Suboptimal(texture) => texture,
            // Nobody sees it; the system asks again when somebody does.
            CurrentSurfaceTexture::Occluded => return Ok(false),
            CurrentSurfaceTexture::Timeout => {
                self.window.request_redraw();
                return Ok(false);
            }
            CurrentSurfaceTexture::Outdated => {
                self.configure();
                self.window.request_redraw();
                return Ok(false);
            }
            CurrentSurfaceTexture::Lost => return Err("the window's surface was lost".into()),
            CurrentSurfaceTexture::Validation => return Err("the window's surface is not valid".into()),
        };
        let rendered = match self.picture.take() {
            Some(picture) if !again => picture,
            _ => self.pipeline.render()?,
        };
        let gpu = self.pipeline.gpu();
        self.blitter.draw(gpu, &rendered.color, rendered.frame.radiance_scale, &texture.texture)?;
        gpu.queue.present(texture);
        self.picture = Some(rendered);
        Ok(true)
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
