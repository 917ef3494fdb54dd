//! Shaders that several combinations use are generated once. Most combinations differ in properties that no text
//! depends on.

use std::collections::HashMap;
use std::fmt::Debug;
use std::sync::{Arc, Mutex};

use cvr_core::shader::{GeneratedShader, Request, generate};
use cvr_core::volume::{SampleType, VolumeLayout};

type Made = Result<Arc<GeneratedShader>, String>;

/// Results by the hash of their request.
static KEPT: Mutex<Option<HashMap<blake3::Hash, Made>>> = Mutex::new(None);

/// The result of `make`, or of an earlier equal request. `asked` must contain everything that the result depends on.
pub fn once(asked: &impl Debug, make: impl FnOnce() -> Result<GeneratedShader, String>) -> Made {
    let key = blake3::hash(format!("{asked:?}").as_bytes());
    if let Some(made) = KEPT.lock().unwrap().get_or_insert_default().get(&key) {
        return made.clone();
    }
    let made = make().map(Arc::new);
    KEPT.lock().unwrap().get_or_insert_default().insert(key, made.clone());
    made
}

/// A layout without the properties that no text depends on: number type and spacing.
pub fn in_text(layout: &VolumeLayout) -> VolumeLayout {
    VolumeLayout { sample: SampleType::U8, spacing: [1.0; 3], ..layout.clone() }
}

/// The shader of a request.
pub fn generated_once(request: &Request<'_>) -> Made {
    let layout = in_text(request.layout);
    let asked = Request { layout: &layout, ..request.clone() };
    once(&asked, || generate(request).map_err(|problem| problem.to_string()))
}

mod tests {
    use super::*;
    use crate::host::combinations::source;
    use crate::host::volumes::{opened, varied};
    use cvr::registry::Names;
    use cvr_codec_tests::offering;
    use cvr_core::codec::Site;
    use cvr_core::shader::{BindingLimits, Program, TextureSampling};

    /// No text depends on the properties that [`in_text`] removes: a stream's shaders are equal for every number type
    /// and spacing.
    #[test]
    fn no_text_depends_on_number_type_or_spacing() {
        let names = Names::new().unwrap();
        for codec in names.codecs().iter() {
            let (info, volume) = (codec.info(), varied([7, 5, 6], SampleType::U8, 1));
            for site in [Site::Inline, Site::Deferred] {
                let Some(settings) = offering(codec.as_ref(), site) else { continue };
                let decoder = opened(codec.as_ref(), &settings, &volume);
                let text = |layout: &VolumeLayout| {
                    let request = Request {
                        program: &Program::dump(cvr_shaders::DUMP),
                        layout,
                        source: source(info.id, decoder.as_ref(), site, TextureSampling::Manual),
                        filter: None,
                        limits: BindingLimits::default(),
                    };
                    generate(&request).unwrap().wgsl
                };
                let own = text(decoder.layout());
                for sample in SampleType::ALL {
                    let other = VolumeLayout { sample, spacing: [0.5, 3.0, 1.0], ..decoder.layout().clone() };
                    assert_eq!(text(&other), own, "{} {site} {sample}", info.id);
                }
            }
        }
    }

    #[test]
    fn another_question_has_another_answer() {
        let answer = |text: &'static str| once(&("once", text), || Err(text.to_owned())).unwrap_err();
        assert_eq!([answer("a"), answer("b"), answer("a")], ["a", "b", "a"]);
        let kept = once(&("once", "a"), || panic!("made twice"));
        assert_eq!(kept.unwrap_err(), "a");
    }
}
