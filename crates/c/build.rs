//! The name that programs find the shared library by: it says with which interface they were linked.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let target = |what: &str| std::env::var(format!("CARGO_CFG_TARGET_{what}")).unwrap_or_default();
    // `install` gives the file this name.
    match (target("OS").as_str(), target("ENV").as_str()) {
        ("linux" | "freebsd" | "android", _) => {
            println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,liblostmotion.so.1");
        }
        ("macos", _) => {
            println!("cargo:rustc-cdylib-link-arg=-Wl,-install_name,@rpath/liblostmotion.1.dylib");
        }
        // Callbacks of JavaScript are put into the table of functions.
        ("unknown", _) => {
            println!("cargo:rustc-cdylib-link-arg=--export-table");
            println!("cargo:rustc-cdylib-link-arg=--growable-table");
        }
        _ => {}
    }
}
