//! [`Picture`]: pixels, and PNG.

/// Pixels, row by row from the top.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// sRGB red, green, blue and straight opacity: `width * height` of them.
    pub pixels: Vec<[u8; 4]>,
}

impl Picture {
    /// The pixel in column `x` from the left and row `y` from the top.
    ///
    /// # Panics
    /// If the picture has no such pixel.
    #[must_use]
    pub fn get(&self, x: u32, y: u32) -> [u8; 4] {
        assert!(
            x < self.width && y < self.height,
            "pixel {x},{y} of {}x{}",
            self.width,
            self.height
        );
        self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// The picture as a PNG file; without opacity where all pixels are opaque.
    ///
    /// # Panics
    /// If a side is zero, or there are not `width * height` pixels.
    #[must_use]
    pub fn to_png(&self) -> Vec<u8> {
        let count = u64::from(self.width) * u64::from(self.height);
        assert!(count > 0 && self.pixels.len() as u64 == count, "width * height pixels");
        let opaque = self.pixels.iter().all(|p| p[3] == 255);
        let bytes: Vec<u8> = if opaque {
            self.pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect()
        } else {
            self.pixels.as_flattened().to_vec()
        };
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.width, self.height);
        encoder.set_color(if opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder
            .write_header()
            .and_then(|mut writer| writer.write_image_data(&bytes))
            .expect("a vector takes every byte, and there are as many as the header says");
        file
    }
}
