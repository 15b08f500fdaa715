//! Frames of an earlier run in the same folder: those that a shorter run would leave behind would be taken for its own.

use serde_json::Value;
use std::{fs, path::Path};

/// Takes away the frames, the contact sheet and the film that the summary in `out` lists, and the summary. Nothing else: pictures that
/// are called after a camera say what they are.
pub fn clear(out: &Path) {
    let summary = out.join("summary.json");
    let Some(Value::Object(earlier)) = fs::read_to_string(&summary).ok().and_then(|text| serde_json::from_str(&text).ok()) else {
        return;
    };
    let Some(frames) = earlier.get("frames").and_then(Value::as_array) else { return };
    let files = frames.iter().filter_map(|frame| frame["file"].as_str()).filter(|name| is_frame(name));
    let others = [super::sheet::FILE, super::film::FILE];
    for name in files.chain(others.into_iter().filter(|name| earlier.values().any(|value| value == name))) {
        let path = out.join(name);
        // Not all of them have an EXR, and some may have been taken away by hand.
        let _ = fs::remove_file(&path);
        let _ = fs::remove_file(path.with_extension("exr"));
    }
    let _ = fs::remove_file(summary);
}

/// "frame_00000.png".
fn is_frame(name: &str) -> bool {
    let number = name.strip_prefix("frame_").and_then(|rest| rest.strip_suffix(".png"));
    number.is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()))
}
