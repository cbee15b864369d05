//! Typed arrays: every component type, normalized integers, strides, sparse substitution; bounds checked first.

use super::buffers::Buffers;
use super::{Fault, item, valid};
use crate::budget::Meter;
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::{Index, Root, buffer};

/// Reads accessors of one file.
#[derive(Clone, Copy)]
pub(super) struct Accessors<'a> {
    pub root: &'a Root,
    pub buffers: &'a Buffers,
    /// Accessors may have no bytes of their own, or be named many times: each reading counts.
    pub meter: &'a Meter,
}

impl Accessors<'_> {
    /// What the accessor says it holds.
    pub(super) fn kind(&self, index: Index<Accessor>, asker: &str) -> Result<Type, Fault> {
        let accessor = item(&self.root.accessors, index, "accessors", asker)?;
        valid(&accessor.type_, &format!("accessors[{}].type", index.value()))
    }

    /// Vectors of `N` floats; normalized integers become 0..1 or -1..1, others their value.
    pub(super) fn floats<const N: usize>(
        &self,
        index: Index<Accessor>,
        kind: Type,
        asker: &str,
    ) -> Result<Vec<[f32; N]>, Fault> {
        self.elements(index, kind, asker, float)
    }

    /// Single floats of whatever vectors the accessor holds, one after the other.
    pub(super) fn flat_floats(
        &self,
        index: Index<Accessor>,
        kind: Type,
        asker: &str,
    ) -> Result<Vec<f32>, Fault> {
        Ok(match kind {
            Type::Scalar => self.floats::<1>(index, kind, asker)?.into_flattened(),
            Type::Vec3 => self.floats::<3>(index, kind, asker)?.into_flattened(),
            _ => self.floats::<4>(index, Type::Vec4, asker)?.into_flattened(),
        })
    }

    /// Vectors of `N` unsigned integers.
    pub(super) fn integers<const N: usize>(
        &self,
        index: Index<Accessor>,
        kind: Type,
        asker: &str,
    ) -> Result<Vec<[u32; N]>, Fault> {
        let component = self.component(index, asker)?;
        if !matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Err(format!(
                "{asker}: accessors[{}] holds {component:?}, not unsigned integers",
                index.value()
            ));
        }
        self.elements(index, kind, asker, |component, _, bytes| integer(component, bytes))
    }

    fn component(&self, index: Index<Accessor>, asker: &str) -> Result<ComponentType, Fault> {
        let accessor = item(&self.root.accessors, index, "accessors", asker)?;
        Ok(valid(&accessor.component_type, &format!("accessors[{}].componentType", index.value()))?.0)
    }

    fn elements<T: Copy + Default, const N: usize>(
        &self,
        index: Index<Accessor>,
        kind: Type,
        asker: &str,
        decode: impl Fn(ComponentType, bool, &[u8]) -> T,
    ) -> Result<Vec<[T; N]>, Fault> {
        let accessor = item(&self.root.accessors, index, "accessors", asker)?;
        let place = format!("accessors[{}]", index.value());
        let (component, found) = (self.component(index, asker)?, self.kind(index, asker)?);
        if found != kind || kind.multiplicity() != N {
            return Err(format!("{asker}: {place} holds {found:?}, {kind:?} is needed"));
        }
        let count = accessor.count.0;
        let taken = self.meter.take(count, (N * size_of::<T>()) as u64);
        taken.map_err(|over| format!("{place}: {count} elements of {kind:?}: {over}"))?;
        let size = component.size();
        let element = |bytes: &[u8]| {
            let mut element = [T::default(); N];
            for (value, bytes) in element.iter_mut().zip(bytes.chunks_exact(size)) {
                *value = decode(component, accessor.normalized, bytes);
            }
            element
        };
        let mut out: Vec<[T; N]> = match accessor.buffer_view {
            Some(view) => {
                let start = accessor.byte_offset.map_or(0, |o| o.0);
                self.run(view, start, count, size * N, &place)?.map(element).collect()
            }
            None => vec![[T::default(); N]; count as usize],
        };
        if let Some(sparse) = &accessor.sparse {
            let place = format!("{place}.sparse");
            let of = valid(&sparse.indices.component_type, &format!("{place}.indices.componentType"))?.0;
            let (indices, values) = (&sparse.indices, &sparse.values);
            let at =
                self.run(indices.buffer_view, indices.byte_offset.0, sparse.count.0, of.size(), &place)?;
            let new = self.run(values.buffer_view, values.byte_offset.0, sparse.count.0, size * N, &place)?;
            for (at, new) in at.zip(new) {
                let at = integer(of, at);
                *out.get_mut(at as usize)
                    .ok_or_else(|| format!("{place}: index {at} of {count} elements"))? = element(new);
            }
        }
        Ok(out)
    }

    /// `count` runs of `size` bytes from byte `start` of a view.
    fn run(
        &self,
        view_index: Index<buffer::View>,
        start: u64,
        count: u64,
        size: usize,
        place: &str,
    ) -> Result<impl Iterator<Item = &[u8]>, Fault> {
        let view = self.buffers.view(self.root, view_index, place)?;
        let stride = view.stride.unwrap_or(size);
        if stride < size {
            return Err(format!("{place}: elements of {size} bytes every {stride} bytes"));
        }
        let needed = match count {
            0 => Some(0),
            _ => (count - 1)
                .checked_mul(stride as u64)
                .and_then(|n| n.checked_add(size as u64)?.checked_add(start)),
        };
        if needed.is_none_or(|needed| needed > view.bytes.len() as u64) {
            let needed = needed.map_or("more than 2^64".into(), |n| n.to_string());
            let (v, found) = (view_index.value(), view.bytes.len());
            return Err(format!("{place}: {needed} bytes needed, bufferViews[{v}] has {found}"));
        }
        // All in range now, or there is nothing to read.
        let bytes = view.bytes.get(start as usize..).unwrap_or_default();
        Ok((0..count as usize).map(move |i| bytes.get(i * stride..i * stride + size).unwrap_or_default()))
    }
}

/// The format is little-endian throughout; `bytes` are those of one component.
fn float(component: ComponentType, normalized: bool, bytes: &[u8]) -> f32 {
    let (value, largest) = match (component, bytes) {
        (ComponentType::I8, &[a]) => (f32::from(a as i8), 127.0),
        (ComponentType::U8, &[a]) => (f32::from(a), 255.0),
        (ComponentType::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), 32_767.0),
        (ComponentType::U16, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), 65_535.0),
        (ComponentType::U32, &[a, b, c, d]) => (u32::from_le_bytes([a, b, c, d]) as f32, u32::MAX as f32),
        (ComponentType::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
        _ => (0.0, 1.0),
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}

fn integer(component: ComponentType, bytes: &[u8]) -> u32 {
    match (component, bytes) {
        (ComponentType::U8, &[a]) => u32::from(a),
        (ComponentType::U16, &[a, b]) => u32::from(u16::from_le_bytes([a, b])),
        (ComponentType::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]),
        _ => 0,
    }
}
