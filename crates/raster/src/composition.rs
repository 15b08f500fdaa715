//! What composition adds up, and which of its programs a scene needs. Twin of `composition.wgsl`.

/// Which parts of the light are in the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parts(u32);

impl Parts {
    const INDIRECT: u32 = 1;
    const DIRECT: u32 = 2;
    const REFLECTED: u32 = 4;
    const ELEMENTS: u32 = 8;

    /// What the camera sees: radiance, cd/m² per linear Rec. 709 channel.
    pub const RADIANCE: Parts = Parts(Self::INDIRECT | Self::DIRECT | Self::REFLECTED);
    /// Its direct part.
    pub const DIRECT_RADIANCE: Parts = Parts(Self::DIRECT | Self::REFLECTED);
    /// Its indirect part.
    pub const INDIRECT_RADIANCE: Parts = Parts(Self::INDIRECT | Self::REFLECTED);
    /// What arrives at the surface: irradiance, lux per channel.
    pub const IRRADIANCE: Parts = Parts(Self::INDIRECT | Self::DIRECT);
    /// Its direct part.
    pub const DIRECT_IRRADIANCE: Parts = Parts(Self::DIRECT);
    /// Its indirect part.
    pub const INDIRECT_IRRADIANCE: Parts = Parts(Self::INDIRECT);
    /// A colour for each mesh element.
    pub const ELEMENT_COLOURS: Parts = Parts(Self::ELEMENTS);

    /// As the shader reads them.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// Whether lamps and their shadows are among them.
    pub const fn direct(self) -> bool {
        self.0 & Self::DIRECT != 0
    }
}

/// What pixels need that others need not pay for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// A texture: for those that see an object with one, after all others.
    pub textured: bool,
    /// Lamps with goniometric diagrams.
    pub goniometric: bool,
    /// How many lamps are drawn; 0 for whichever number.
    pub lamps: u32,
}

impl Variant {
    /// A program for each number of lamps, if there are few.
    pub fn new(textured: bool, goniometric: bool, lamps: usize) -> Variant {
        const MOST: usize = 8;
        Variant { textured, goniometric, lamps: if lamps <= MOST { lamps as u32 } else { 0 } }
    }
}
