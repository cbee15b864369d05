//! How what was rendered is put on the screen; of all this only the comparison reaches the worker.

/// How A and B are put on one screen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Compare {
    /// Only A.
    #[default]
    Off,
    /// A left of the divider, B right of it.
    Split,
    /// One after the other in one place.
    Flicker,
    /// How far B's radiance is from A's, per channel.
    Difference,
    /// LDR-FLIP of B against A.
    Flip,
}

impl Compare {
    /// In the order of the menu.
    pub const ALL: [Self; 5] = [Self::Off, Self::Split, Self::Flicker, Self::Difference, Self::Flip];

    /// As the menu and scripts call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Split => "split",
            Self::Flicker => "flicker",
            Self::Difference => "difference",
            Self::Flip => "FLIP",
        }
    }
}

/// Which numbers of a texel are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel {
    /// As a display shows them.
    #[default]
    Color,
    /// The first alone, grey.
    Red,
    /// The second alone, grey.
    Green,
    /// The third alone, grey.
    Blue,
    /// Rec. 709, grey.
    Luminance,
}

impl Channel {
    /// In the order of the menu.
    pub const ALL: [Self; 5] = [Self::Color, Self::Red, Self::Green, Self::Blue, Self::Luminance];

    /// As the menu calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Color => "colour",
            Self::Red => "red",
            Self::Green => "green",
            Self::Blue => "blue",
            Self::Luminance => "luminance",
        }
    }
}

/// How radiance becomes something to look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Development {
    /// Stops added.
    pub exposure_stops: f32,
    /// Which numbers.
    pub channel: Channel,
    /// Eight stops of luminance around the exposure's grey as colours of a map.
    pub false_color: bool,
    /// Paints what is no radiance: NaN magenta, infinity cyan, negative green.
    pub mark_strange: bool,
}

impl Default for Development {
    fn default() -> Self {
        Self { exposure_stops: 0.0, channel: Channel::Color, false_color: false, mark_strange: true }
    }
}
