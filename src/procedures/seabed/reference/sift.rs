//! Keypoints of an image and their matches: Lowe's SIFT as the crate `kornia-imgproc` has it, with its settings, which are those of `OpenCV`.

use super::image::{Grey, Image};

/// Keypoints of an image with their descriptors.
#[derive(Clone, Debug, Default)]
pub struct Keypoints {
    /// Column and row of each.
    pub at: Vec<[f64; 2]>,
    #[cfg(feature = "sift")]
    descriptors: Vec<f32>,
}

/// Keypoints of an image at most, the most pronounced ones.
#[cfg(feature = "sift")]
const MOST_KEYPOINTS: usize = 4000;
/// Lowe's ratio: the second-best match is so much further at least.
#[cfg(feature = "sift")]
const RATIO: f32 = 0.8;

/// Whether this build can find keypoints.
pub const BUILT: bool = cfg!(feature = "sift");

/// Finds the keypoints of an image; none where the image is too small, or in a build without SIFT.
#[must_use]
pub fn keypoints(image: &Image, grey: Grey) -> Keypoints {
    of_pixels(&image.grey(grey), image.width, image.height)
}

/// Finds the keypoints of pixels in grey levels from 0 to 255, row by row.
#[cfg(feature = "sift")]
#[must_use]
pub fn of_pixels(pixels: &[f32], width: usize, height: usize) -> Keypoints {
    use kornia_imgproc::features::{
        FirstOctave, SiftConfig, SiftWorkspace, sift_detect_and_compute,
    };
    let config = SiftConfig {
        n_features: MOST_KEYPOINTS,
        ..SiftConfig::default()
    };
    let found = sift_detect_and_compute(
        &mut SiftWorkspace::new(),
        pixels,
        width,
        height,
        &config,
        FirstOctave::Double,
        usize::MAX,
        false,
    );
    let found = found.unwrap_or_default();
    let place = |x: f32, y: f32| [f64::from(x), f64::from(y)];
    Keypoints {
        at: found.keypoints.iter().map(|k| place(k.x, k.y)).collect(),
        descriptors: found.descriptors,
    }
}

/// Pairs of keypoints that are each other's nearest, by number.
#[cfg(feature = "sift")]
#[must_use]
pub fn matches(a: &Keypoints, b: &Keypoints) -> Vec<[usize; 2]> {
    use kornia_imgproc::features::sift_match_descriptors;
    let pairs = sift_match_descriptors(
        &a.descriptors,
        a.at.len(),
        &b.descriptors,
        b.at.len(),
        RATIO,
        true,
    );
    let number = |k: i32| usize::try_from(k).ok();
    let pair = |[i, j]: [i32; 2]| Some([number(i)?, number(j)?]);
    pairs.into_iter().filter_map(pair).collect()
}

/// None: this build has no SIFT.
#[cfg(not(feature = "sift"))]
#[must_use]
pub fn of_pixels(_: &[f32], _: usize, _: usize) -> Keypoints {
    Keypoints::default()
}

/// None: this build has no SIFT.
#[cfg(not(feature = "sift"))]
#[must_use]
pub fn matches(_: &Keypoints, _: &Keypoints) -> Vec<[usize; 2]> {
    vec![]
}
