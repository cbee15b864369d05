//! Images on the CPU side: what twins work on and files are written from.

/// A row-major picture, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Image<T> {
    size: [u32; 2],
    texels: Vec<T>,
}

impl<T: Copy> Image<T> {
    /// The same value everywhere.
    pub fn filled(size: [u32; 2], value: T) -> Self {
        Self { size, texels: vec![value; size[0] as usize * size[1] as usize] }
    }

    /// From rows, if there are as many texels as the size says.
    pub fn from_texels(size: [u32; 2], texels: Vec<T>) -> Option<Self> {
        (texels.len() == size[0] as usize * size[1] as usize).then_some(Self { size, texels })
    }

    /// One value per pixel from its coordinates.
    pub fn from_fn(size: [u32; 2], mut value: impl FnMut(u32, u32) -> T) -> Self {
        let texels =
            (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| value(x, y)).collect();
        Self { size, texels }
    }

    /// Pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// All texels, row by row.
    pub fn texels(&self) -> &[T] {
        &self.texels
    }

    /// One texel, or none outside.
    pub fn get(&self, x: i32, y: i32) -> Option<T> {
        let inside = x >= 0 && y >= 0 && (x as u32) < self.size[0] && (y as u32) < self.size[1];
        inside.then(|| self.texels[y as usize * self.size[0] as usize + x as usize])
    }

    /// One texel to write, or none outside.
    pub fn get_mut(&mut self, x: i32, y: i32) -> Option<&mut T> {
        let inside = x >= 0 && y >= 0 && (x as u32) < self.size[0] && (y as u32) < self.size[1];
        inside.then(|| &mut self.texels[y as usize * self.size[0] as usize + x as usize])
    }

    /// Another value per texel.
    pub fn map<U: Copy>(&self, f: impl FnMut(T) -> U) -> Image<U> {
        Image { size: self.size, texels: self.texels.iter().copied().map(f).collect() }
    }
}

/// Rec. 709 luminance of linear RGB: the one in the whole tree.
pub fn luminance(rgb: [f32; 3]) -> f32 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}
