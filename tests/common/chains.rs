//! Scene files of chains.

#[path = "../../codegen/examples/make.rs"]
#[allow(dead_code, unreachable_pub, reason = "the command around it is not used")]
mod make;

use std::fs;

use tempfile::TempDir;

/// A scene file with thirteen links in a chain, which is a large tree.
pub(crate) fn chain() -> (TempDir, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("relative-13.toml");
    fs::write(&scene, make::chain(13, make::Chain::Relative)).expect("written");
    let scene = scene.to_str().expect("a name").to_owned();
    (folder, scene)
}

/// The chain with stiff damped springs in its joints.
pub(crate) fn stiff_chain() -> (TempDir, String) {
    let (folder, scene) = chain();
    let text = fs::read_to_string(&scene).expect("a scene");
    let spring = |i: u32| format!("spring{i} = {{ along = 'a{i}', force = '-2000*s - 20*s_dot' }}\n");
    let springs: String = (1..13).map(spring).collect();
    let text = text.replace("[loads]\n", &format!("[loads]\n{springs}")).replace("[run]\n", "[run]\nstiff = true\n");
    fs::write(&scene, text).expect("written");
    (folder, scene)
}
