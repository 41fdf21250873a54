//! `qrm animate`

use std::path::Path;

use super::arguments::AnimateArguments;
use super::progress::Progress;
use super::setup::Setup;
use super::{Failure, account};
use crate::album::Album;
use crate::animation::motion;
use crate::scenes::Scenes;

/// Runs a scene and writes its animation.
pub(super) fn animate(scenes: &Scenes, arguments: &AnimateArguments) -> Result<(), Failure> {
    let setup = Setup::new(scenes, &arguments.scene, &arguments.method)?;
    let out = setup.folder(arguments.out.as_deref());
    let mut observer = (Progress::new(), Album::new(&setup.description));
    let outcome = setup.simulate(false, &mut observer)?;
    let album = observer.1;
    let summary = account::summary(&setup, &outcome, &album);
    if album.frames.len() < 2 {
        return Err(Failure::Run(format!("error: {}", summary.message)));
    }
    let motion =
        motion(&setup.text, &setup.parameters(), &album).map_err(|reason| Failure::Run(format!("error: {reason}")))?;
    super::say(&format!("{}: {}\n", summary.scene, summary.message));
    write(&out.join("animation.html"), qrm_view::animation::page(&motion).as_bytes())?;
    if !arguments.no_gif {
        let gif = qrm_view::gif::gif(&motion).map_err(|e| Failure::Run(format!("error: no GIF could be made: {e}")))?;
        write(&out.join("animation.gif"), &gif)?;
    }
    account::problem(&outcome, &summary).map_or(Ok(()), |problem| Err(Failure::Run(problem)))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    super::save(path, bytes)?;
    super::say(&format!("wrote {} ({} kB)", path.display(), bytes.len().div_ceil(1000)));
    Ok(())
}
