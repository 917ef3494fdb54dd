//! The page's script, and the policy that lets it and nothing else run.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

/// By subject, in the order of the page.
const PARTS: [&str; 7] = [
    include_str!("script/data.js"),
    include_str!("script/axis.js"),
    include_str!("script/chart.js"),
    include_str!("script/detail.js"),
    include_str!("script/compare.js"),
    include_str!("script/selftest.js"),
    include_str!("script/start.js"),
];

/// The script: one function, so that nothing of it is global.
pub(super) fn text() -> String {
    format!("(() => {{\n\"use strict\";\n{}}})();\n", PARTS.concat())
}

/// What the page may load: pictures in it or beside it, its own styles, and this script by its hash. The script and
/// the policy can so not drift apart, and text from a record that slipped through the escaper would still not run.
pub(super) fn policy() -> String {
    // The browser hashes all between the tags, the template's line breaks among it.
    let hash = STANDARD.encode(Sha256::digest(format!("\n{}\n", text())));
    format!(
        "default-src 'none'; img-src data: 'self' file:; style-src 'unsafe-inline'; script-src 'sha256-{hash}'; \
         base-uri 'none'; form-action 'none'"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_script_cannot_end_its_element_and_names_nothing_outside() {
        let text = text();
        for word in
            ["</", "<!--", "http:", "https:", "fetch(", "XMLHttpRequest", "innerHTML", "eval(", "import("]
        {
            assert!(!text.contains(word), "{word}");
        }
    }
}
