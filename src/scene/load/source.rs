//! Finding and reading the files of a scene.

use std::fs;
use std::path::{Component, Path, PathBuf};

/// Larger files are refused.
const LARGEST_FILE: u64 = 4 << 30;

/// What is wrong, and what to do about it.
pub(super) type Refusal = (String, &'static str);

/// The text of a file; bytes that are not UTF-8 become U+FFFD.
pub(super) fn read_text(path: &Path) -> Result<String, Refusal> {
    let unreadable =
        |error: std::io::Error| (format!("cannot be read ({error})"), "check the path and its permissions");
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if metadata.is_dir() {
        return Err((String::from("is a folder"), "name a file in it"));
    }
    if !metadata.is_file() {
        return Err((String::from("is not a regular file"), "copy it to a file first"));
    }
    if metadata.len() > LARGEST_FILE {
        let size = metadata.len() >> 30;
        return Err((format!("is {size} GiB long, more than the 4 GiB that are read"), "split or simplify the scene"));
    }
    decode(fs::read(path).map_err(unreadable)?)
}

fn decode(bytes: Vec<u8>) -> Result<String, Refusal> {
    if bytes.is_empty() {
        return Err((String::from("the file is empty"), "export it again"));
    }
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err((String::from("the file is UTF-16 text"), "save it as UTF-8 or ASCII"));
    }
    if let Some(place) = bytes.iter().position(|&byte| byte == 0) {
        let problem = format!("the file is binary, not text (a zero at byte {place})");
        return Err((problem, "give a text file; convert other formats first"));
    }
    let text = String::from_utf8(bytes).unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned());
    let text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
    // Old Macintosh files end their lines with a carriage return alone.
    Ok(if text.contains('\r') && !text.contains('\n') { text.replace('\r', "\n") } else { text })
}

/// The file that `name` means, seen from `folder`: as it is written, then in any letter case, then its last part
/// alone (a path of somebody else's machine). Backslashes count as slashes.
pub(super) fn find(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = name.trim().trim_matches('"').replace('\\', "/");
    let written = Path::new(&name);
    if name.is_empty() {
        return None;
    }
    let whole = find_in_any_case(folder, written);
    whole.or_else(|| find_in_any_case(folder, Path::new(written.file_name()?)))
}

fn find_in_any_case(folder: &Path, name: &Path) -> Option<PathBuf> {
    let exact = folder.join(name);
    if exact.is_file() {
        return Some(exact);
    }
    let mut place = folder.to_path_buf();
    for component in name.components() {
        match component {
            Component::CurDir => {}
            Component::Normal(part) if !place.join(part).exists() => place.push(entry_like(&place, part.to_str()?)?),
            other => place.push(other),
        }
    }
    place.is_file().then_some(place)
}

/// The first entry, in order of names, that differs from `part` in letter case only.
fn entry_like(folder: &Path, part: &str) -> Option<String> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let wanted = part.to_lowercase();
    let names = fs::read_dir(folder).ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    names.filter(|name| name.to_lowercase() == wanted).min()
}

#[cfg(test)]
mod tests {
    #[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
    #[test]
    fn files_are_found_in_other_letter_case_behind_backslashes_and_by_their_last_part() {
        let folder = tempfile::tempdir().unwrap();
        let textures = folder.path().join("Textures");
        std::fs::create_dir(&textures).unwrap();
        let (wood, beside) = (textures.join("Old Wood.PNG"), folder.path().join("stone.png"));
        std::fs::write(&wood, "").unwrap();
        std::fs::write(&beside, "").unwrap();
        let find = |name: &str| super::find(folder.path(), name);
        assert_eq!(find(".\\textures\\old wood.png").as_ref(), Some(&wood));
        assert_eq!(find("Textures/../textures/Old Wood.PNG ").map(|path| path.is_file()), Some(true));
        assert_eq!(find("C:\\Users\\somebody\\Stone.png").as_ref(), Some(&beside));
        assert_eq!(find("absent.png"), None);
        assert_eq!(find(" "), None);
    }

    #[test]
    fn text_is_decoded_whatever_its_bytes_and_line_ends() {
        let decode = |bytes: &[u8]| super::decode(bytes.to_vec()).map_err(|(problem, _)| problem);
        assert_eq!(decode(b"\xef\xbb\xbfv 1"), Ok(String::from("v 1")));
        assert_eq!(decode(b"# caf\xe9"), Ok(String::from("# caf\u{fffd}")));
        assert_eq!(decode(b"v 1\rv 2"), Ok(String::from("v 1\nv 2")));
        assert_eq!(decode(b"\xfe\xff\0v"), Err(String::from("the file is UTF-16 text")));
        assert_eq!(decode(b"v\0"), Err(String::from("the file is binary, not text (a zero at byte 1)")));
    }
}
