//! How Rust describes what a shader binds.

/// A field of a struct that both sides know: its name and byte offset.
pub type Field = (&'static str, usize);

/// A plain Rust struct that a shader reads under the same field names. Made by [`crate::gpu_struct!`].
pub trait GpuStruct: bytemuck::Pod {
    /// Name in WGSL.
    const NAME: &'static str;
    /// All fields, in order. A field whose name begins with `_` is padding: WGSL need not have it.
    const FIELDS: &'static [Field];
}

/// Declares a `#[repr(C)]` struct with the list of its fields, to be compared with the WGSL struct of the same name.
#[macro_export]
macro_rules! gpu_struct {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$doc:meta])* pub $field:ident : $type:ty),* $(,)? }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, $crate::bytemuck::Pod, $crate::bytemuck::Zeroable)]
        #[bytemuck(crate = "::frame::bytemuck")]
        pub struct $name { $($(#[$doc])* pub $field: $type),* }

        impl $crate::GpuStruct for $name {
            const NAME: &'static str = stringify!($name);
            const FIELDS: &'static [$crate::Field] =
                &[$((stringify!($field), ::core::mem::offset_of!($name, $field))),*];
        }
    };
}

/// What kind of thing is bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindKind {
    /// `var<uniform>`.
    Uniform,
    /// `var<storage, read>`.
    StorageRead,
    /// `var<storage, read_write>`.
    Storage,
    /// `texture_2d<f32>` or an array of it, only loaded from.
    TextureFloat {
        /// `texture_2d_array`.
        array: bool,
    },
    /// `texture_2d<u32>`.
    TextureUint,
    /// `texture_storage_2d<format, write>`.
    StorageTexture(wgpu::TextureFormat),
}

/// One declared binding.
#[derive(Clone, Copy, Debug)]
pub struct Bind {
    pub(crate) group: u32,
    pub(crate) binding: u32,
    pub(crate) name: &'static str,
    pub(crate) kind: BindKind,
    pub(crate) structure: Option<Structure>,
}

/// A struct's name, fields and size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Structure {
    pub(crate) name: &'static str,
    pub(crate) fields: &'static [Field],
    pub(crate) size: usize,
}

impl Bind {
    const fn new(group: u32, binding: u32, name: &'static str, kind: BindKind) -> Self {
        Self { group, binding, name, kind, structure: None }
    }

    /// A uniform struct.
    pub const fn uniform<T: GpuStruct>(group: u32, binding: u32, name: &'static str) -> Self {
        Self::new(group, binding, name, BindKind::Uniform).of::<T>()
    }

    /// A uniform array of vectors.
    pub const fn uniform_array(group: u32, binding: u32, name: &'static str) -> Self {
        Self::new(group, binding, name, BindKind::Uniform)
    }

    /// A read-only storage buffer.
    pub const fn storage_read(group: u32, binding: u32, name: &'static str) -> Self {
        Self::new(group, binding, name, BindKind::StorageRead)
    }

    /// A read-write storage buffer.
    pub const fn storage(group: u32, binding: u32, name: &'static str) -> Self {
        Self::new(group, binding, name, BindKind::Storage)
    }

    /// A float texture that is loaded from.
    pub const fn texture(group: u32, binding: u32, name: &'static str) -> Self {
        Self::new(group, binding, name, BindKind::TextureFloat { array: false })
    }

    /// An array of float textures that is loaded from.
    pub const fn texture_array(group: u32, binding: u32, name: &'static str) -> Self {
        Self::new(group, binding, name, BindKind::TextureFloat { array: true })
    }

    /// An unsigned integer texture.
    pub const fn texture_uint(group: u32, binding: u32, name: &'static str) -> Self {
        Self::new(group, binding, name, BindKind::TextureUint)
    }

    /// A texture that is stored to.
    pub const fn storage_texture(
        group: u32,
        binding: u32,
        name: &'static str,
        format: wgpu::TextureFormat,
    ) -> Self {
        Self::new(group, binding, name, BindKind::StorageTexture(format))
    }

    /// Says that the buffer holds this struct (or an array of it), so that its fields are compared.
    #[must_use]
    pub const fn of<T: GpuStruct>(mut self) -> Self {
        self.structure = Some(Structure { name: T::NAME, fields: T::FIELDS, size: size_of::<T>() });
        self
    }

    pub(crate) fn layout_entry(&self, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
        let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let texture = |sample_type, array| wgpu::BindingType::Texture {
            sample_type,
            view_dimension: if array {
                wgpu::TextureViewDimension::D2Array
            } else {
                wgpu::TextureViewDimension::D2
            },
            multisampled: false,
        };
        // Fragments may write storage within the default limits, vertices may not.
        let visibility = match self.kind {
            BindKind::Storage | BindKind::StorageTexture(_) => visibility & !wgpu::ShaderStages::VERTEX,
            _ => visibility,
        };
        let ty = match self.kind {
            BindKind::Uniform => buffer(wgpu::BufferBindingType::Uniform),
            BindKind::StorageRead => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
            BindKind::Storage => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
            BindKind::TextureFloat { array } => {
                texture(wgpu::TextureSampleType::Float { filterable: false }, array)
            }
            BindKind::TextureUint => texture(wgpu::TextureSampleType::Uint, false),
            BindKind::StorageTexture(format) => wgpu::BindingType::StorageTexture {
                access: wgpu::StorageTextureAccess::WriteOnly,
                format,
                view_dimension: wgpu::TextureViewDimension::D2,
            },
        };
        wgpu::BindGroupLayoutEntry { binding: self.binding, visibility, ty, count: None }
    }
}
