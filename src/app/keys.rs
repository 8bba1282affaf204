//! The keys: what they are called, what they do, and which commands come of them.

use egui::{Event, InputState, Key, Modifiers};
use glam::Vec3;

use super::{command::Command, file_dialog::Purpose};

/// The keys as the help shows them, with what they do.
pub const HELP: [(&str, &str); 30] = [
    ("W A S D", "fly forward, left, back, right"),
    ("Q E", "fly down, up"),
    ("left drag", "look round"),
    ("wheel", "flying speed"),
    ("click", "tell about the point of the surface"),
    ("SPACE", "put the area light at the camera, shining where it looks"),
    ("ENTER", "solve; again: start anew with what is set now"),
    ("ESC", "stop solving and keep the result; close help and dialogs"),
    ("P", "let the solve wait, or go on"),
    ("N", "one bounce more, then wait (P goes on); starts a solve if none runs"),
    ("M", "load a mesh (OBJ); or drop one on the window"),
    ("O", "save the solution as a mesh (PLY)"),
    ("CTRL + S", "save the solution"),
    ("CTRL + L", "load a solution"),
    ("ALT + number", "save camera, light, settings and tone map to states/"),
    ("number", "load the state of that number"),
    ("F12, ALT + Print", "screenshot to screenshots/"),
    ("F1, ?", "this help"),
    ("F2", "panels on or off"),
    ("F3", "plots on or off"),
    ("F4", "frame times, stage by stage, on or off"),
    ("V", "next view: radiosity, irradiance, direct, indirect, ..."),
    ("B", "wireframe over the view"),
    ("F", "false colours with a legend in W/m²"),
    ("U", "ambient light for looking round, on or off"),
    ("X", "second view beside the first, with a divider to drag"),
    ("R", "read the lightmap's shaders again (from src/gpu/lightmap, while one works on them)"),
    ("CTRL + Z", "undo; with SHIFT: redo"),
    ("CTRL + C", "copy camera and light as one line of text"),
    ("CTRL + V", "take camera and light from such a line"),
];

/// The rule for changes while a solve runs, as the help says it.
pub const RULE: &str = "Changes of the light, a material or a setting wait for the next ENTER; a solve that runs is not \
disturbed. But once a solve is complete, its rays are kept: while “Relight live” is on, changes of the light and of \
materials light them again at once, on the elements of the last ENTER. Views and tone map change at once.";

const PLAIN: [(Key, Command); 16] = [
    (Key::Enter, Command::Solve),
    (Key::Space, Command::PlaceLight),
    (Key::P, Command::PauseOrResume),
    (Key::N, Command::Step),
    (Key::M, Command::Ask(Purpose::OpenScene)),
    (Key::O, Command::Ask(Purpose::SaveMesh)),
    (Key::F1, Command::ToggleHelp),
    (Key::F2, Command::TogglePanels),
    (Key::F3, Command::TogglePlots),
    (Key::F4, Command::ToggleFrameTimes),
    (Key::V, Command::NextView),
    (Key::B, Command::ToggleWireframe),
    (Key::F, Command::ToggleFalseColour),
    (Key::U, Command::ToggleAmbient),
    (Key::X, Command::ToggleSecondView),
    (Key::R, Command::ReloadShaders),
];

const DIGITS: [Key; 10] =
    [Key::Num0, Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];

/// The commands of the keys that were pressed since the last frame.
pub fn commands(input: &InputState) -> Vec<Command> {
    input.events.iter().filter_map(command).collect()
}

fn command(event: &Event) -> Option<Command> {
    match event {
        Event::Copy => Some(Command::CopyView),
        Event::Paste(text) => Some(Command::PasteView(text.clone())),
        Event::Key { key, pressed: true, repeat: false, modifiers, .. } => key_command(*key, *modifiers),
        _ => None,
    }
}

fn key_command(key: Key, modifiers: Modifiers) -> Option<Command> {
    if modifiers.command {
        let undo = if modifiers.shift { Command::Redo } else { Command::Undo };
        return match key {
            Key::Z => Some(undo),
            Key::S => Some(Command::Ask(Purpose::SaveSolution)),
            Key::L => Some(Command::Ask(Purpose::LoadSolution)),
            _ => None,
        };
    }
    if let Some(digit) = DIGITS.iter().position(|&known| known == key) {
        let digit = digit as u8;
        return Some(if modifiers.alt { Command::SaveNumber(digit) } else { Command::LoadNumber(digit) });
    }
    if modifiers.alt {
        return (key == Key::PrintScreen).then_some(Command::Screenshot);
    }
    match key {
        Key::Escape => Some(Command::Cancel),
        Key::F12 => Some(Command::Screenshot),
        Key::Questionmark => Some(Command::ToggleHelp),
        _ => PLAIN.iter().find(|(known, _)| *known == key).map(|(_, command)| command.clone()),
    }
}

/// Where the keys that are held down fly to: x to the right, y up, z forward.
pub fn flight(input: &InputState) -> Vec3 {
    if input.modifiers.any() && !input.modifiers.shift_only() {
        return Vec3::ZERO;
    }
    let axis = |plus, minus| f32::from(u8::from(input.key_down(plus))) - f32::from(u8::from(input.key_down(minus)));
    Vec3::new(axis(Key::D, Key::A), axis(Key::E, Key::Q), axis(Key::W, Key::S))
}
