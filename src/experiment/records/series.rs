//! Which curve a cell belongs to, as its codec says.

use cvr_core::codec::{SettingValue, Settings};
use cvr_core::pipeline::Cell;

use super::record::Record;
use crate::registry::codecs;

/// Settings as a record writes them. All values are text. `None` if the text is not such a list.
#[must_use]
pub fn read(settings: &str) -> Option<Settings> {
    let mut read = Settings::default();
    for setting in shlex::split(settings)? {
        let (name, value) = setting.split_once('=')?;
        read.set(name, SettingValue::Text(value.to_owned()));
    }
    Some(read)
}

/// Enters the series of a record of a version without this column.
pub fn restore(record: &mut Record) {
    if !record.series.is_empty() {
        return;
    }
    let Ok(codecs) = codecs() else { return };
    if let (Ok(codec), Some(settings)) =
        (codecs.get(Cell::codec_of_label(&record.codec)), read(&record.settings))
    {
        record.series = codec.info().series(&settings);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::records::record::tests::record;

    #[test]
    fn older_records_get_the_series_that_newer_ones_have() {
        let restored = |codec: &str, settings: &str, series: &str| {
            let mut r = Record { settings: settings.into(), series: series.into(), ..record("v", codec) };
            restore(&mut r);
            r.series
        };
        assert_eq!(restored("tvq", "init=pca payload=variable rate=2", ""), "payload=variable init=pca");
        assert_eq!(restored("external:x", "name=x sample=f32", ""), "sample=f32");
        assert_eq!(restored("tvq", "payload=variable", "payload=fixed"), "payload=fixed", "as it was run");
        for (codec, settings) in
            [("raw", "bits=8"), ("gone", "payload=x"), ("tvq", "payload='x"), ("tvq", "x")]
        {
            assert_eq!(restored(codec, settings, ""), "", "{codec} {settings}");
        }
    }
}
