#![no_main]
//! COLLADA, OBJ and STL; the first byte says which.

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use openbench_fuzz::Folder;

static FOLDER: LazyLock<Folder> = LazyLock::new(Folder::new);

fuzz_target!(|bytes: &[u8]| {
    let Some((&kind, mesh)) = bytes.split_first() else {
        return;
    };
    let name = ["a.dae", "a.obj", "a.stl"][usize::from(kind) % 3];
    FOLDER.put(&format!("thing/meshes/{name}"), mesh);
    let world = format!(
        "<sdf version='1.7'><world name='w'><model name='text_model1'/><model name='thing'><link name='l'><visual name='v'><geometry>\
         <mesh><uri>model://thing/meshes/{name}</uri></mesh></geometry></visual></link></model></world></sdf>"
    );
    let _ = FOLDER.import(world.as_bytes());
});
