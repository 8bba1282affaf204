//! What keys and panels ask of the window.

use std::path::PathBuf;

use super::file_dialog::Purpose;
use crate::scene::LoadOptions;

/// A wish; the window fulfils it after all panels were drawn, so that no panel reaches into another.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Start to solve, or start again with what is set now.
    Solve,
    /// One bounce more, and then wait.
    Step,
    /// Stop solving and keep what there is.
    Cancel,
    /// Let the solve wait, or go on.
    PauseOrResume,
    /// Put the area light at the camera.
    PlaceLight,
    /// Show the list of keys, or put it away; Escape does the latter, too.
    ToggleHelp,
    /// Show or hide the panels on the left.
    TogglePanels,
    /// Show or hide the plots.
    TogglePlots,
    /// Show or hide the frame times.
    ToggleFrameTimes,
    /// Show or hide the second view.
    ToggleSecondView,
    /// The next of the views.
    NextView,
    /// Edges of the elements over the view.
    ToggleWireframe,
    /// False colours.
    ToggleFalseColour,
    /// Ambient light for looking round.
    ToggleAmbient,
    /// Play the bounces back, one after the other.
    Play,
    /// Ask for a file.
    Ask(Purpose),
    /// Open a scene.
    OpenScene(PathBuf),
    /// Read the scene again, with these options.
    ReadAgain(LoadOptions),
    /// Write the solution as a mesh with vertex colours (PLY) or a table (CSV).
    SaveMesh(PathBuf),
    /// Write the solution.
    SaveSolution(PathBuf),
    /// Read a solution and show it.
    LoadSolution(PathBuf),
    /// Read a solution to compare with.
    LoadOther(PathBuf),
    /// Compare the solution with a truth file.
    CompareWithTruth(PathBuf),
    /// Write the curves of convergence, as a table (CSV) or a picture (PNG).
    SavePlots(PathBuf),
    /// Start to solve the lightmap on the graphics card, or start again.
    SolveLightmap,
    /// Find form factors on the graphics card, and the radiosity that follows from them sweep by sweep; or stop it.
    FormFactors,
    /// Read the lightmap's shaders again from the source tree.
    ReloadShaders,
    /// Keep the present solution to compare with.
    KeepForComparison,
    /// Write camera, light, settings and tone map.
    SaveState(PathBuf),
    /// Read camera, light, settings and tone map.
    LoadState(PathBuf),
    /// Save the state of a digit.
    SaveNumber(u8),
    /// Load the state of a digit.
    LoadNumber(u8),
    /// Write a picture of the window.
    Screenshot,
    /// Take back the last change of light, settings, materials or tone map.
    Undo,
    /// Bring it back.
    Redo,
    /// Camera and light as a line of text to the clipboard.
    CopyView,
    /// Camera and light from a line of text.
    PasteView(String),
    /// Look from where the scene's state looks.
    ResetCamera,
    /// Test a task of the assignment, or all.
    Check(Option<&'static str>),
    /// Tell what went wrong.
    Complain(String),
}
