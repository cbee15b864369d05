//! A shader with its entry point, checked against what Rust says about it before the driver sees it.
//!
//! A kernel lists its WGSL sources in order and declares its bindings. naga validates the text; its reflection is then
//! compared with the declaration: binding numbers and kinds, the workgroup size, the offset of every field of every
//! declared struct. A mismatch is an error that names the field. Variants are `override` constants.

mod bind;
mod edits;
mod reflect;

pub use bind::{Bind, BindKind, Field, GpuStruct};
pub(crate) use edits::Edits;

use crate::Gpu;

/// Why a kernel was refused.
#[derive(Debug, thiserror::Error)]
pub enum KernelError {
    /// The WGSL does not parse or validate.
    #[error("kernel {kernel}: {message}")]
    Shader {
        /// The kernel's name.
        kernel: String,
        /// naga's message with the place in the joined source.
        message: String,
    },
    /// The Rust side describes it wrongly.
    #[error("kernel {kernel}: {what}: Rust says {rust}, WGSL says {wgsl}")]
    Mismatch {
        /// The kernel's name.
        kernel: String,
        /// The binding or field.
        what: String,
        /// Declared.
        rust: String,
        /// Reflected.
        wgsl: String,
    },
    /// The driver refused the pipeline.
    #[error("kernel {kernel}: the driver refused it: {message}")]
    Pipeline {
        /// The kernel's name.
        kernel: String,
        /// wgpu's words.
        message: String,
    },
}

/// A compute kernel, described.
pub struct KernelDesc<'a> {
    /// For messages and labels.
    pub name: &'a str,
    /// WGSL texts, joined in this order: shared snippets first, the pass last.
    pub sources: &'a [&'a str],
    /// Entry point.
    pub entry: &'a str,
    /// Must equal the entry point's `@workgroup_size`.
    pub workgroup: [u32; 3],
    /// Every global the entry point uses, by group and binding. [`crate::Recorder::compute`] takes the resources in
    /// this order.
    pub bindings: &'a [Bind],
    /// Values of `override` constants.
    pub constants: &'a [(&'a str, f64)],
}

/// A compute pipeline with its layouts.
pub struct Kernel {
    pub(crate) name: String,
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) layout: Layout,
}

impl Kernel {
    /// Validates, compares, builds.
    ///
    /// # Errors
    /// See [`KernelError`].
    pub fn new(gpu: &Gpu, desc: &KernelDesc<'_>) -> Result<Self, KernelError> {
        let source = gpu.edits.of(desc.sources.join("\n"));
        reflect::check(desc.name, &source, &[desc.entry], Some(desc.workgroup), desc.bindings)?;
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let layout = Layout::new(gpu, desc.name, desc.bindings, wgpu::ShaderStages::COMPUTE);
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(desc.name),
            layout: Some(&layout.pipeline),
            module: &module(gpu, desc.name, source),
            entry_point: Some(desc.entry),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: desc.constants,
                ..Default::default()
            },
            cache: None,
        });
        refused(desc.name, scope)?;
        Ok(Self { name: desc.name.into(), pipeline, layout })
    }

    /// The kernel's name.
    pub fn name(&self) -> &str {
        &self.name
    }
}

/// A raster kernel, described. Vertices are pulled from storage buffers by index.
pub struct RasterDesc<'a> {
    /// For messages and labels.
    pub name: &'a str,
    /// WGSL texts, joined in this order.
    pub sources: &'a [&'a str],
    /// Vertex and fragment entry points.
    pub entries: [&'a str; 2],
    /// Every global either entry point uses.
    pub bindings: &'a [Bind],
    /// Values of `override` constants.
    pub constants: &'a [(&'a str, f64)],
    /// Colour targets; a format with no writes at all is how a pass without a picture is made.
    pub targets: &'a [wgpu::ColorTargetState],
    /// Depth test, if any.
    pub depth: Option<wgpu::DepthStencilState>,
}

/// A render pipeline with its layouts: triangle list, no culling.
pub struct RasterKernel {
    pub(crate) name: String,
    pub(crate) pipeline: wgpu::RenderPipeline,
    pub(crate) layout: Layout,
}

impl RasterKernel {
    /// Validates, compares, builds.
    ///
    /// # Errors
    /// See [`KernelError`].
    pub fn new(gpu: &Gpu, desc: &RasterDesc<'_>) -> Result<Self, KernelError> {
        let source = gpu.edits.of(desc.sources.join("\n"));
        reflect::check(desc.name, &source, &desc.entries, None, desc.bindings)?;
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let layout = Layout::new(gpu, desc.name, desc.bindings, wgpu::ShaderStages::VERTEX_FRAGMENT);
        let module = module(gpu, desc.name, source);
        let options = || wgpu::PipelineCompilationOptions { constants: desc.constants, ..Default::default() };
        let targets: Vec<_> = desc.targets.iter().cloned().map(Some).collect();
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(desc.name),
            layout: Some(&layout.pipeline),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(desc.entries[0]),
                compilation_options: options(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: desc.depth.clone(),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(desc.entries[1]),
                compilation_options: options(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        });
        refused(desc.name, scope)?;
        Ok(Self { name: desc.name.into(), pipeline, layout })
    }
}

fn module(gpu: &Gpu, name: &str, source: String) -> wgpu::ShaderModule {
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(name),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    })
}

fn refused(name: &str, scope: wgpu::ErrorScopeGuard) -> Result<(), KernelError> {
    match pollster::block_on(scope.pop()) {
        Some(e) => Err(KernelError::Pipeline { kernel: name.into(), message: e.to_string() }),
        None => Ok(()),
    }
}

/// Bind group layouts, and which entry of the flat resource list goes where.
pub(crate) struct Layout {
    pub(crate) groups: Vec<wgpu::BindGroupLayout>,
    pipeline: wgpu::PipelineLayout,
    places: Vec<(u32, u32)>,
}

impl Layout {
    fn new(gpu: &Gpu, name: &str, bindings: &[Bind], visibility: wgpu::ShaderStages) -> Self {
        let group_count = bindings.iter().map(|b| b.group + 1).max().unwrap_or(0);
        let groups: Vec<_> = (0..group_count)
            .map(|group| {
                let entries: Vec<_> = bindings
                    .iter()
                    .filter(|b| b.group == group)
                    .map(|b| b.layout_entry(visibility))
                    .collect();
                gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                    label: Some(name),
                    entries: &entries,
                })
            })
            .collect();
        let borrowed: Vec<_> = groups.iter().map(Some).collect();
        let pipeline = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(name),
            bind_group_layouts: &borrowed,
            immediate_size: 0,
        });
        Self { groups, pipeline, places: bindings.iter().map(|b| (b.group, b.binding)).collect() }
    }

    /// One bind group per layout from resources in the order of the declared bindings; `group_of` makes or finds each.
    pub(crate) fn bind(
        &self,
        name: &str,
        resources: &[wgpu::BindingResource<'_>],
        group_of: impl Fn(&wgpu::BindGroupLayout, &[wgpu::BindGroupEntry<'_>]) -> wgpu::BindGroup,
    ) -> Vec<wgpu::BindGroup> {
        assert_eq!(self.places.len(), resources.len(), "{name}: resources against declared bindings");
        (0u32..)
            .zip(&self.groups)
            .map(|(group, layout)| {
                let entries: Vec<_> = self
                    .places
                    .iter()
                    .zip(resources)
                    .filter(|((g, _), _)| *g == group)
                    .map(|((_, binding), resource)| wgpu::BindGroupEntry {
                        binding: *binding,
                        resource: resource.clone(),
                    })
                    .collect();
                group_of(layout, &entries)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests;
