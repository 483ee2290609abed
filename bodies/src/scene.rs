//! Road frames that stand in for a camera: a road in perspective, lane markings that run towards the viewer, and a
//! car in front that is there or not.
//!
//! All arithmetic is in integers, so a frame is the same on every machine and a function of its index alone.

use crate::BodyError;

/// Distance unit: a row `r` below the horizon shows the road at `DEPTH * height / r`.
const DEPTH: u64 = 256;
/// Length of a dash and of the gap behind it, in the same unit.
const DASH: u64 = 640;
/// How far the viewer drives from frame to frame.
const STEP: u64 = 112;

type Rgb = [u8; 3];

const SKY: Rgb = [150, 190, 235];
const GRASS: Rgb = [62, 120, 52];
const ASPHALT: Rgb = [84, 84, 90];
const PAINT: Rgb = [236, 236, 224];
const BODYWORK: Rgb = [176, 28, 30];
const GLASS: Rgb = [34, 42, 58];
const TYRE: Rgb = [18, 18, 20];

/// A generator of frames of one size.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    width: usize,
    height: usize,
}

impl Scene {
    /// Frames of `width` by `height` pixels.
    #[must_use]
    pub const fn new(width: usize, height: usize) -> Self {
        Self { width, height }
    }

    /// Number of values in a frame.
    #[must_use]
    pub const fn len(&self) -> usize {
        3 * self.width * self.height
    }

    /// Whether the frame has no pixel.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Draws frame number `frame`, with the car in front if `obstacle`, into `image`: red, green and blue plane, each
    /// in rows from the top, values `n / 255` from 0 to 1. Allocates nothing.
    ///
    /// # Errors
    /// `image` does not hold [`Self::len`] values.
    pub fn draw(&self, frame: u64, obstacle: bool, image: &mut [f32]) -> Result<(), BodyError> {
        BodyError::check_len("image", self.len(), image.len())?;
        let car = obstacle.then(|| Car::at(frame, self.width, self.height));
        for y in 0..self.height {
            for x in 0..self.width {
                let car = car.as_ref().and_then(|car| car.colour(x, y));
                let colour = car.unwrap_or_else(|| self.ground(frame, x, y));
                for (plane, value) in colour.into_iter().enumerate() {
                    image[(plane * self.height + y) * self.width + x] = f32::from(value) / 255.0;
                }
            }
        }
        Ok(())
    }

    /// The pixel without the car.
    fn ground(&self, frame: u64, x: usize, y: usize) -> Rgb {
        let horizon = self.height * 2 / 5;
        if y < horizon {
            // The sky pales towards the horizon.
            let pale = (y * 60 / horizon) as u8;
            return SKY.map(|value| value.saturating_add(pale));
        }
        let row = y - horizon + 1;
        let distance = (DEPTH * self.height as u64 / row as u64).wrapping_add(STEP.wrapping_mul(frame));
        let dash = (distance / DASH).is_multiple_of(2);
        // Across the road: 0 in its middle, 1,000 at its edge.
        let half = self.width * row * 11 / (self.height * 12) + 1;
        let across = (2 * x + 1).abs_diff(self.width) * 500 / half;
        match across {
            0..20 | 320..345 if dash => PAINT,
            940..1_000 => PAINT,
            0..1_000 => ASPHALT,
            _ => GRASS.map(|value| if dash { value } else { value - 8 }),
        }
    }
}

/// The car in front: a box with a rear window and two wheels.
struct Car {
    left: usize,
    top: usize,
    size: usize,
}

impl Car {
    /// Where it is in a frame: it sways in its lane and comes nearer and falls back, with a period of 64 frames.
    fn at(frame: u64, width: usize, height: usize) -> Self {
        let phase = (frame % 64) as usize;
        let near = if phase < 32 { phase } else { 64 - phase };
        let size = height / 6 + height * near / 160;
        let bottom = height * 11 / 20 + height * near / 128;
        let middle = width * 7 / 16 + width * near / 512;
        // Where the frame is too small for the car, a part of it is outside.
        Self { left: middle.saturating_sub(size / 2), top: bottom.saturating_sub(size), size: size.max(1) }
    }

    /// Its colour at a pixel, `None` outside of it.
    fn colour(&self, x: usize, y: usize) -> Option<Rgb> {
        let (x, y) = (x.checked_sub(self.left)?, y.checked_sub(self.top)?);
        // In parts of a hundred of its own box.
        match (x * 100 / self.size, y * 100 / self.size) {
            (100.., _) | (_, 100..) => None,
            (18..82, 10..42) => Some(GLASS),
            (8..28 | 72..92, 84..) => Some(TYRE),
            (_, 84..) | (0..10 | 90.., 0..42) => None,
            _ => Some(BODYWORK),
        }
    }
}

#[cfg(test)]
mod tests;
