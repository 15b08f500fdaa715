//! Everything that can be done by menu or key, in one table: what it is called, its key, and what it does.

use egui::{Key, KeyboardShortcut, Modifiers};

/// Something to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    OpenScene,
    Save,
    SaveAs,
    AddObject,
    PlayScript,
    StopScript,
    SaveRecording,
    Picture,
    PictureExr,
    Quit,
    Undo,
    Redo,
    Duplicate,
    Delete,
    Deselect,
    TurnLeft,
    TurnRight,
    TurnLeftFine,
    TurnRightFine,
    Raise,
    Lower,
    Snapping,
    SwitchLamp,
    Radiance,
    Illuminance,
    Indirect,
    Elements,
    Stale,
    Face,
    FullScreen,
    RestartGraphics,
    Pause,
    StartOver,
    Help,
}

/// The menus, from left to right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Menu {
    File,
    Edit,
    View,
    Light,
    Help,
}

impl Menu {
    pub const ALL: [Menu; 5] = [Menu::File, Menu::Edit, Menu::View, Menu::Light, Menu::Help];

    pub fn title(self) -> &'static str {
        match self {
            Menu::File => "File",
            Menu::Edit => "Edit",
            Menu::View => "View",
            Menu::Light => "Light",
            Menu::Help => "Help",
        }
    }
}

/// A line of a menu.
pub struct Entry {
    pub command: Command,
    pub menu: Menu,
    pub title: &'static str,
    pub key: Option<KeyboardShortcut>,
    pub hint: &'static str,
}

const fn entry(command: Command, menu: Menu, title: &'static str, key: Option<(Modifiers, Key)>, hint: &'static str) -> Entry {
    let key = match key {
        Some((modifiers, key)) => Some(KeyboardShortcut::new(modifiers, key)),
        None => None,
    };
    Entry { command, menu, title, key, hint }
}

const PLAIN: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;
const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

/// All of them, in the order of the menus.
pub const TABLE: [Entry; 34] = [
    entry(Command::OpenScene, Menu::File, "Open…", Some((CTRL, Key::O)), "Another scene file, in this window"),
    entry(Command::Save, Menu::File, "Save", Some((CTRL, Key::S)), "Writes the scene as it is to its file"),
    entry(Command::SaveAs, Menu::File, "Save as…", Some((CTRL_SHIFT, Key::S)), "Writes the scene as it is to another file"),
    entry(Command::AddObject, Menu::File, "Add object…", Some((CTRL, Key::I)), "An OBJ file; or drop it on the window"),
    entry(Command::PlayScript, Menu::File, "Play moves…", Some((CTRL, Key::P)), "A moves file, in this window"),
    entry(Command::StopScript, Menu::File, "Stop playing", None, "The script that plays stops where it is"),
    entry(
        Command::SaveRecording,
        Menu::File,
        "Save moves…",
        Some((CTRL, Key::M)),
        "Everything that was done since the scene was opened, as a moves file that frames, replay and apply read",
    ),
    entry(
        Command::Picture,
        Menu::File,
        "Picture (PNG)",
        Some((PLAIN, Key::F12)),
        "What is seen, without the panels, beside the scene file",
    ),
    entry(
        Command::PictureExr,
        Menu::File,
        "Picture (EXR)",
        Some((SHIFT, Key::F12)),
        "Linear light in cd/m², its direct and indirect parts, a mask for each lamp",
    ),
    entry(Command::Quit, Menu::File, "Quit", Some((CTRL, Key::Q)), "Asks first if something is not saved"),
    entry(Command::Undo, Menu::Edit, "Undo", Some((CTRL, Key::Z)), "Without limit"),
    entry(Command::Redo, Menu::Edit, "Redo", Some((CTRL_SHIFT, Key::Z)), "What was undone, again"),
    entry(Command::Duplicate, Menu::Edit, "Duplicate", Some((CTRL, Key::D)), "A copy of what is selected, beside it"),
    entry(Command::Delete, Menu::Edit, "Delete", Some((PLAIN, Key::Delete)), "What is selected, and what rides on it"),
    entry(Command::Deselect, Menu::Edit, "Select nothing", Some((PLAIN, Key::Escape)), "Also ends a drag where it began"),
    entry(
        Command::TurnLeft,
        Menu::Edit,
        "Turn left",
        Some((PLAIN, Key::R)),
        "What is selected, 15° seen from above; also the wheel over it",
    ),
    entry(
        Command::TurnRight,
        Menu::Edit,
        "Turn right",
        Some((PLAIN, Key::T)),
        "What is selected, 15° seen from above; also the wheel over it",
    ),
    entry(Command::TurnLeftFine, Menu::Edit, "Turn left, 1°", Some((SHIFT, Key::R)), "Also Shift and the wheel"),
    entry(Command::TurnRightFine, Menu::Edit, "Turn right, 1°", Some((SHIFT, Key::T)), "Also Shift and the wheel"),
    entry(Command::Raise, Menu::Edit, "Raise", Some((PLAIN, Key::PageUp)), "What is selected, 5 cm; also Shift while dragging"),
    entry(Command::Lower, Menu::Edit, "Lower", Some((PLAIN, Key::PageDown)), "What is selected, 5 cm; also Shift while dragging"),
    entry(
        Command::Snapping,
        Menu::Edit,
        "Snapping",
        Some((PLAIN, Key::N)),
        "Dragged objects keep to floor and walls; off, or with Ctrl, they go anywhere",
    ),
    entry(Command::SwitchLamp, Menu::Edit, "Switch lamp", Some((PLAIN, Key::L)), "The lamp that is selected, on or off"),
    entry(Command::Radiance, Menu::View, "What a camera sees", Some((PLAIN, Key::F2)), "Radiance, exposed like a photograph"),
    entry(
        Command::Illuminance,
        Menu::View,
        "Illuminance",
        Some((PLAIN, Key::F3)),
        "All light that arrives at surfaces, lux, in false colours",
    ),
    entry(
        Command::Indirect,
        Menu::View,
        "Indirect illuminance",
        Some((PLAIN, Key::F4)),
        "The light that arrives from other surfaces, lux, in false colours",
    ),
    entry(
        Command::Elements,
        Menu::View,
        "Mesh elements",
        Some((PLAIN, Key::F5)),
        "The elements that hold the light, each in a colour of its own",
    ),
    entry(
        Command::Stale,
        Menu::View,
        "What is still wrong",
        Some((PLAIN, Key::F6)),
        "How far the indirect light is from exact, as a share of it. After every edit this shoots a second pool, as much work as starting over",
    ),
    entry(Command::Face, Menu::View, "Go to what is selected", Some((PLAIN, Key::F)), "So that it fills half of the picture"),
    entry(Command::FullScreen, Menu::View, "Full screen", Some((PLAIN, Key::F11)), "And back"),
    entry(
        Command::RestartGraphics,
        Menu::View,
        "Restart graphics",
        Some((CTRL_SHIFT, Key::G)),
        "Gives the graphics device up and takes it anew, as after a driver's fault; nothing is lost",
    ),
    entry(
        Command::Pause,
        Menu::Light,
        "Pause repair",
        Some((PLAIN, Key::Space)),
        "Paused: photons stay as they were shot, and all time is left for frames. Going on: what became wrong is re-shot",
    ),
    entry(
        Command::StartOver,
        Menu::Light,
        "Start over",
        Some((CTRL, Key::R)),
        "Throws all light away and shoots the pool anew: noise first, all of it. Repair keeps what is right and comes to the same bits",
    ),
    entry(Command::Help, Menu::Help, "Keys and mouse", Some((PLAIN, Key::F1)), "All of them"),
];

/// What mouse and held keys do.
pub const MOUSE: [(&str, &str); 14] = [
    ("W A S D", "walk; Shift: faster"),
    ("E, Q", "rise, sink"),
    ("Right drag; left drag on nothing", "look around"),
    ("Middle drag; Alt + left drag", "orbit what is selected, or what is under the pointer"),
    ("Shift + middle drag", "slide the camera"),
    ("Wheel", "go forwards, back"),
    ("1 to 9", "the cameras of the scene"),
    ("Click", "select an object or a lamp"),
    ("Drag an object", "slide it on what it stands on; what stands on it rides along"),
    ("Ctrl while dragging", "anywhere, without snapping"),
    ("Shift while dragging", "up and down"),
    ("Wheel over what is selected, or while dragging", "turn it by 15°; Shift: 1°"),
    ("Arrow keys", "move what is selected by 5 cm; Shift: 1 cm"),
    ("Right click while dragging; Esc", "put it back"),
];

/// The commands whose keys were pressed, taken out of the input. While a text is typed or a menu is open (`busy`), keys without Ctrl
/// belong to that, and so do undo and redo.
pub fn pressed(ctx: &egui::Context, busy: bool) -> Vec<Command> {
    // Those with more modifiers first: Ctrl+Z is also in Ctrl+Shift+Z.
    let mut entries: Vec<&Entry> = TABLE.iter().filter(|e| e.key.is_some()).collect();
    entries.sort_by_key(|e| std::cmp::Reverse(e.key.map_or(0, |k| u8::from(k.modifiers.shift) + u8::from(k.modifiers.command))));
    let function_key = |key: Key| key.name().starts_with('F') && key.name().len() > 1;
    ctx.input_mut(|input| {
        let hit = |e: &&&Entry| {
            let Some(key) = e.key else { return false };
            let text_has_it_too = matches!(e.command, Command::Undo | Command::Redo);
            let allowed = !busy || (key.modifiers.command && !text_has_it_too) || function_key(key.logical_key);
            allowed && input.consume_shortcut(&key)
        };
        entries.iter().filter(hit).map(|e| e.command).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_means_two_things_and_all_are_in_a_menu() {
        for (n, a) in TABLE.iter().enumerate() {
            assert!(Menu::ALL.contains(&a.menu) && !a.hint.is_empty());
            for b in &TABLE[n + 1..] {
                assert_ne!(a.command, b.command);
                assert!(a.key.is_none() || a.key != b.key, "{} and {}", a.title, b.title);
            }
        }
    }
}
