//! Colours, mixed as the eye does.

/// Halvings of the interval in which the largest chroma that can be shown is looked for: finer than a byte shows.
const HALVINGS: usize = 12;

/// A colour as amounts of light: linear red, green and blue of the sRGB primaries, each in `[0, 1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colour(pub [f64; 3]);

impl Colour {
    pub const WHITE: Colour = Colour([1.0; 3]);

    /// The colour of a lightness in `[0, 1]`, a chroma and a hue in turns, in Oklab [Ott20]. What no screen shows loses
    /// chroma until one does.
    pub fn of(lightness: f64, chroma: f64, hue: f64) -> Colour {
        let (b, a) = (std::f64::consts::TAU * hue).sin_cos();
        let at = |chroma: f64| linear([lightness, chroma * a, chroma * b]);
        let shown = |rgb: [f64; 3]| rgb.iter().all(|x| (-1e-6..=1.0 + 1e-6).contains(x));
        let (mut low, mut high) = (0.0, chroma);
        if shown(at(chroma)) {
            low = chroma;
        } else {
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if shown(at(middle)) { low = middle } else { high = middle }
            }
        }
        Colour::clamped(at(low))
    }

    /// The grey of a lightness in `[0, 1]`.
    pub fn grey(lightness: f64) -> Colour {
        Colour::of(lightness, 0.0, 0.0)
    }

    /// The colour at these coordinates of Oklab, brought into what a screen shows.
    pub fn of_oklab(lab: [f64; 3]) -> Colour {
        Colour::clamped(linear(lab))
    }

    /// Lightness, green–red and blue–yellow: distances between them are those that are seen.
    pub fn oklab(self) -> [f64; 3] {
        let [r, g, b] = self.0;
        let l = (0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b).cbrt();
        let m = (0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b).cbrt();
        let s = (0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b).cbrt();
        [
            0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
            1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
            0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s,
        ]
    }

    /// This colour with a share in `[0, 1]` of the other, mixed in Oklab.
    pub fn mixed(self, other: Colour, share: f64) -> Colour {
        let (from, to) = (self.oklab(), other.oklab());
        Colour::of_oklab(std::array::from_fn(|i| from[i] + share * (to[i] - from[i])))
    }

    /// This colour in less light: `light` in `[0, 1]`.
    pub fn lit(self, light: f64) -> Colour {
        Colour(self.0.map(|x| x * light))
    }

    /// The mean of colours by weights that sum to 1, as light adds up.
    pub fn mean<const N: usize>(colours: [Colour; N], weights: [f64; N]) -> Colour {
        let sum = |i: usize| colours.iter().zip(weights).map(|(colour, weight)| weight * colour.0[i]).sum();
        Colour(std::array::from_fn(sum))
    }

    /// Red, green and blue as a picture stores them, in sRGB.
    pub fn bytes(self) -> [u8; 3] {
        self.0.map(|x| {
            let x = x.clamp(0.0, 1.0);
            let encoded = if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
            (255.0 * encoded).round() as u8
        })
    }

    /// As SVG writes it: `#rrggbb`.
    pub fn hex(self) -> String {
        let [r, g, b] = self.bytes();
        format!("#{r:02x}{g:02x}{b:02x}")
    }

    /// The colour that a picture stores as these amounts of red, green and blue in sRGB, each in `[0, 1]`.
    pub fn of_srgb(rgb: [f64; 3]) -> Colour {
        Colour(rgb.map(|x| {
            let x = x.clamp(0.0, 1.0);
            if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
        }))
    }

    fn clamped(rgb: [f64; 3]) -> Colour {
        Colour(rgb.map(|x| x.clamp(0.0, 1.0)))
    }
}

/// Linear red, green and blue of a colour in Oklab; out of `[0, 1]` where no screen shows it.
fn linear([lightness, a, b]: [f64; 3]) -> [f64; 3] {
    let l = (lightness + 0.3963377774 * a + 0.2158037573 * b).powi(3);
    let m = (lightness - 0.1055613458 * a - 0.0638541728 * b).powi(3);
    let s = (lightness - 0.0894841775 * a - 1.2914855480 * b).powi(3);
    [
        4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
        -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
        -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s,
    ]
}

/// From blue at −1 over white at 0 to red at 1.
pub fn diverging(value: f64) -> Colour {
    let end = if value < 0.0 { Colour::of(0.48, 0.16, 0.71) } else { Colour::of(0.48, 0.18, 0.07) };
    Colour::WHITE.mixed(end, value.abs().min(1.0))
}

/// How different two colours look; 0.02 is about the least that is noticed.
#[cfg(test)]
pub fn difference(a: Colour, b: Colour) -> f64 {
    crate::geometry::length(crate::geometry::subtract(a.oklab(), b.oklab()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_black_and_red_are_themselves() {
        assert_eq!(Colour::grey(1.0).bytes(), [255; 3]);
        assert_eq!(Colour::grey(0.0).bytes(), [0; 3]);
        let red = Colour([1.0, 0.0, 0.0]);
        assert_eq!((red.hex().as_str(), Colour::of_oklab(red.oklab()).bytes()), ("#ff0000", [255, 0, 0]));
        assert!((red.oklab()[0] - 0.628).abs() < 1e-3);
        assert_eq!(Colour([0.5; 3]).bytes(), [188; 3]);
    }

    #[test]
    fn what_cannot_be_shown_keeps_its_hue_and_lightness() {
        let [lightness, a, b] = Colour::of(0.7, 5.0, 0.3).oklab();
        assert!((lightness - 0.7).abs() < 1e-3);
        assert!((b.atan2(a) / std::f64::consts::TAU - 0.3).abs() < 1e-3);
        assert!(a.hypot(b) > 0.1);
    }

    #[test]
    fn mixtures_lie_between() {
        let (blue, yellow) = (Colour::of(0.5, 0.1, 0.7), Colour::of(0.9, 0.1, 0.3));
        assert!(difference(blue.mixed(yellow, 0.0), blue) < 1e-6 && difference(blue.mixed(yellow, 1.0), yellow) < 1e-6);
        assert!((blue.mixed(yellow, 0.5).oklab()[0] - 0.7).abs() < 1e-6);
    }
}
