//! All pictures of a scene in ten texture arrays, so that one dispatch can read any material within default limits.
//!
//! In: 8-bit pictures and what they are used as. Out: a `texture_2d_array` per encoding (sRGB, linear) and square size
//! class (128 to 2048 texels), all mips made here ([`super::texels`]).
//!
//! A picture lies in the corner of a layer of the smallest class it fits, at its own size: shaders wrap and filter by
//! hand (`material_lookup`), so nothing is stretched and mip 0 is the file's, bit for bit. A full class spills into the
//! next larger one. Pictures beyond 2048 texels, and the largest ones while the pool is over its budget, are averaged
//! to half their sides, again and again, with a warning.

use super::SceneGpuError;
use super::texels::{Encoding, Plane};
use crate::{Gpu, Room, Texture};
use scene::Image;
use std::collections::HashMap;
use wgpu::{TextureFormat, TextureUsages};

/// Sides of the square size classes.
pub const CLASSES: [u32; 5] = [128, 256, 512, 1024, 2048];
const LARGEST: u32 = CLASSES[CLASSES.len() - 1];
const ARRAYS: usize = 2 * CLASSES.len();

/// A picture as it is used: the same one used in two ways is stored twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Use {
    /// Index into [`scene::Scene::images`].
    pub image: u32,
    /// What its colours mean.
    pub encoding: Encoding,
    /// For masks: alpha codes from here on are solid, those below are holes.
    pub threshold: Option<u16>,
}

/// Where a picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Index into [`TexturePool::arrays`].
    pub array: u32,
    /// Layer of the array.
    pub layer: u32,
    /// Columns and rows of mip 0.
    pub size: [u32; 2],
}

impl Place {
    /// Number of the last mip, of a single texel.
    pub fn last_mip(&self) -> u32 {
        self.size[0].max(self.size[1]).ilog2()
    }
}

/// The arrays and who is where.
#[derive(Clone)]
pub struct TexturePool {
    /// sRGB arrays by growing class, then linear ones. An unused one is a single texel.
    pub arrays: [Texture; ARRAYS],
    places: HashMap<Use, Place>,
}

impl TexturePool {
    /// Uploads what is used; the second value are warnings.
    ///
    /// # Errors
    /// More pictures than there are layers, or out of memory.
    pub fn new(
        gpu: &Gpu,
        images: &[Image],
        uses: &[Use],
        budget_bytes: u64,
    ) -> Result<(Self, Vec<String>), SceneGpuError> {
        let sizes = uses.iter().map(|u| size_of_image(images, u)).collect();
        let plan = Plan::new(uses, sizes, budget_bytes, gpu.device.limits().max_texture_array_layers)?;
        let mut arrays = Vec::with_capacity(ARRAYS);
        for (array, &layers) in plan.layers.iter().enumerate() {
            arrays.push(new_array(gpu, array, layers)?);
        }
        // The loop above made one per entry of an array of this length.
        let arrays: [Texture; ARRAYS] =
            arrays.try_into().unwrap_or_else(|_| unreachable!("TexturePool: {ARRAYS} arrays"));
        for (u, place) in uses.iter().zip(&plan.places) {
            if let Some(image) = images.get(u.image as usize) {
                upload(gpu, &arrays[place.array as usize], image, u, place);
            }
        }
        let places = uses.iter().copied().zip(plan.places).collect();
        Ok((Self { arrays, places }, plan.warnings))
    }

    /// Where a picture that was asked for is.
    pub fn place(&self, wanted: &Use) -> Option<Place> {
        self.places.get(wanted).copied()
    }

    /// Bit i is set where array i holds a picture.
    pub fn used_arrays(&self) -> u32 {
        self.places.values().fold(0, |used, place| used | (1 << place.array))
    }

    /// Bytes of all arrays.
    pub fn bytes(&self) -> u64 {
        self.arrays.iter().map(Texture::bytes).sum()
    }
}

fn size_of_image(images: &[Image], u: &Use) -> [u32; 2] {
    images.get(u.image as usize).map_or([1, 1], |image| [image.width.max(1), image.height.max(1)])
}

fn new_array(gpu: &Gpu, array: usize, layers: u32) -> Result<Texture, SceneGpuError> {
    let (kind, format) = match array < CLASSES.len() {
        true => ("srgb", TextureFormat::Rgba8UnormSrgb),
        false => ("linear", TextureFormat::Rgba8Unorm),
    };
    let class = CLASSES[array % CLASSES.len()];
    let (side, mips) = if layers == 0 { (1, 1) } else { (class, class.ilog2() + 1) };
    let label = format!("TexturePool::{kind}_{class}");
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST | TextureUsages::COPY_SRC;
    Ok(gpu.texture(Room::Scene, &label, [side, side, layers.max(1)], mips, format, usage)?.as_array())
}

fn upload(gpu: &Gpu, array: &Texture, image: &Image, u: &Use, place: &Place) {
    let size = [image.width as usize, image.height as usize];
    let wanted = place.size.map(|n| n as usize);
    let mut plane = Plane::decode(size, &image.rgba, u.encoding, u.threshold);
    if size != wanted {
        plane = plane.averaged(wanted);
    }
    for mip in 0..=place.last_mip() {
        if mip > 0 {
            plane = plane.mip();
        }
        let texels = plane.encode(u.encoding);
        super::write(
            gpu,
            array,
            mip,
            place.layer,
            plane.size.map(|n| n as u32),
            bytemuck::cast_slice(&texels),
        );
    }
    // Lets wgpu free its staging memory before the next picture.
    gpu.queue.submit([]);
}

/// Who goes where, before anything is uploaded.
pub(super) struct Plan {
    /// One per use.
    pub places: Vec<Place>,
    /// Per array.
    pub layers: [u32; ARRAYS],
    /// What had to be made smaller.
    pub warnings: Vec<String>,
}

impl Plan {
    pub(super) fn new(
        uses: &[Use],
        mut sizes: Vec<[u32; 2]>,
        budget_bytes: u64,
        most_layers: u32,
    ) -> Result<Self, SceneGpuError> {
        let mut warnings = Vec::new();
        let longest = sizes.iter().flatten().copied().max().unwrap_or(1);
        if longest > LARGEST {
            let count =
                sizes.iter_mut().filter(|size| size[0].max(size[1]) > LARGEST).map(halve_to_largest).count();
            warnings.push(format!(
                "{count} textures of up to {longest} texels a side are averaged to at most {LARGEST}"
            ));
        }
        let before = bytes(&assign(uses, &sizes, most_layers)?.1);
        let mut after = before;
        while after > budget_bytes {
            let longest = sizes.iter().flatten().copied().max().unwrap_or(1);
            if longest <= CLASSES[0] {
                break;
            }
            let class = class_of(longest);
            for size in sizes.iter_mut().filter(|size| class_of(size[0].max(size[1])) == class) {
                *size = size.map(|n| (n / 2).max(1));
            }
            after = bytes(&assign(uses, &sizes, most_layers)?.1);
        }
        let (places, layers) = assign(uses, &sizes, most_layers)?;
        if after != before {
            let longest = sizes.iter().flatten().copied().max().unwrap_or(1);
            let mb = |bytes: u64| bytes as f64 / 1e6;
            warnings.push(format!(
                "textures need {:.0} MB, the budget is {:.0} MB: averaged to at most {longest} texels a side, {:.0} MB",
                mb(before),
                mb(budget_bytes),
                mb(after)
            ));
        }
        Ok(Self { places, layers, warnings })
    }
}

fn halve_to_largest(size: &mut [u32; 2]) {
    while size[0].max(size[1]) > LARGEST {
        *size = size.map(|n| n.div_ceil(2));
    }
}

/// Index of the smallest class that holds this many texels a side.
fn class_of(side: u32) -> usize {
    CLASSES.iter().position(|&class| side <= class).unwrap_or(CLASSES.len() - 1)
}

/// First come, first served; who finds a class full goes to the next larger one.
fn assign(
    uses: &[Use],
    sizes: &[[u32; 2]],
    most_layers: u32,
) -> Result<(Vec<Place>, [u32; ARRAYS]), SceneGpuError> {
    // Large ones first: they have the fewest classes to go to.
    let mut order: Vec<_> = (0..uses.len()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse(class_of(sizes[i][0].max(sizes[i][1]))));
    let mut layers = [0; ARRAYS];
    let mut places = vec![Place { array: 0, layer: 0, size: [1, 1] }; uses.len()];
    for i in order {
        let first = match uses[i].encoding {
            Encoding::Srgb => 0,
            Encoding::Linear => CLASSES.len(),
        };
        let classes = class_of(sizes[i][0].max(sizes[i][1]))..CLASSES.len();
        let Some(array) = classes.map(|class| first + class).find(|&array| layers[array] < most_layers)
        else {
            let allowed = most_layers as usize * CLASSES.len();
            return Err(SceneGpuError::TooManyTextures { count: uses.len(), allowed });
        };
        places[i] = Place { array: array as u32, layer: layers[array], size: sizes[i] };
        layers[array] += 1;
    }
    Ok((places, layers))
}

fn bytes(layers: &[u32; ARRAYS]) -> u64 {
    let class_bytes =
        |class: u32| (0..=class.ilog2()).map(|mip| 4 * u64::from(class >> mip).pow(2)).sum::<u64>();
    layers.iter().zip(CLASSES.iter().cycle()).map(|(&n, &class)| u64::from(n) * class_bytes(class)).sum()
}
