//! The room's reflectances, linear Rec. 709: paints and woods of the usual kinds, about one half on average by area.

use crate::scene::Material;

/// All materials, by name.
pub fn all() -> Vec<Material> {
    let mut all = vec![
        ("wall white", [0.74, 0.70, 0.62], None),
        ("ceiling white", [0.80, 0.79, 0.76], None),
        ("floorboards", [0.42, 0.29, 0.18], None),
        ("skirting white", [0.72, 0.70, 0.66], None),
        ("oak", [0.50, 0.35, 0.20], None),
        ("beech", [0.58, 0.42, 0.26], None),
        ("walnut", [0.22, 0.13, 0.08], None),
        ("pine", [0.62, 0.45, 0.24], None),
        ("sofa cloth", [0.30, 0.36, 0.40], None),
        ("ochre cloth", [0.62, 0.38, 0.08], None),
        ("teal cloth", [0.08, 0.30, 0.32], None),
        ("headboard cloth", [0.36, 0.33, 0.30], None),
        ("linen", [0.76, 0.74, 0.69], None),
        ("duvet", [0.42, 0.52, 0.62], None),
        ("curtain cloth", [0.56, 0.34, 0.26], None),
        ("screen paper", [0.72, 0.66, 0.52], None),
        ("fringe", [0.68, 0.60, 0.44], None),
        ("rug", [1.0, 1.0, 1.0], Some("textures/rug.png")),
        ("wardrobe paint", [0.52, 0.56, 0.48], None),
        ("wardrobe panel", [0.44, 0.49, 0.41], None),
        ("door paint", [0.70, 0.68, 0.62], None),
        ("brass", [0.55, 0.40, 0.16], None),
        ("black steel", [0.05, 0.05, 0.05], None),
        ("enamel", [0.80, 0.79, 0.76], None),
        ("lamp shade", [0.75, 0.68, 0.54], None),
        ("china", [0.78, 0.77, 0.74], None),
        ("orange peel", [0.80, 0.30, 0.03], None),
        ("lemon peel", [0.82, 0.66, 0.08], None),
        ("terracotta", [0.50, 0.20, 0.11], None),
        ("leaf", [0.10, 0.26, 0.06], None),
        ("glaze blue", [0.10, 0.20, 0.44], None),
        ("glaze white", [0.74, 0.74, 0.70], None),
        ("cardboard", [0.45, 0.32, 0.20], None),
        ("box lid", [0.56, 0.14, 0.10], None),
        ("night", [0.02, 0.025, 0.035], None),
        ("sea", [0.10, 0.26, 0.40], None),
        ("sand", [0.68, 0.54, 0.34], None),
        ("sky", [0.48, 0.62, 0.74], None),
        ("cream", [0.74, 0.68, 0.56], None),
        ("book red", [0.44, 0.07, 0.06], None),
        ("book blue", [0.07, 0.14, 0.36], None),
        ("book green", [0.09, 0.24, 0.13], None),
        ("book cream", [0.68, 0.60, 0.44], None),
        ("book black", [0.06, 0.06, 0.07], None),
        ("book ochre", [0.56, 0.36, 0.08], None),
        ("book violet", [0.26, 0.12, 0.30], None),
    ];
    all.sort_by_key(|m| m.0);
    all
}
