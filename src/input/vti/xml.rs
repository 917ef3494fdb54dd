//! From a file to its [`Header`], in one pass that never holds values: those in place are passed over.
//!
//! Entities are never expanded and a document type is refused, so that no XML can grow. What stands between values
//! may take a mebibyte.

use std::fs::File;
use std::io::{BufRead, BufReader, Error, Read};
use std::path::Path;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::super::header::shown;
use super::super::payload::open_regular;
use super::super::{ByteOrder, InputError, Place};
use super::header::{Appended, Array, Association, Format, Header, sample_type};

/// Most bytes of XML between two arrays of values.
const MAX_XML_BYTES: u64 = 1 << 20;
/// Elements within elements. Real files have five.
const MAX_DEPTH: usize = 16;

/// A reader that refuses to give more than it has left.
struct Rationed<R> {
    inner: R,
    left: u64,
}

impl<R: BufRead> BufRead for Rationed<R> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        let buffer = self.inner.fill_buf()?;
        if self.left == 0 && !buffer.is_empty() {
            return Err(Error::other("more than a mebibyte of XML without values"));
        }
        let n = buffer.len().min(usize::try_from(self.left).unwrap_or(usize::MAX));
        Ok(&buffer[..n])
    }

    fn consume(&mut self, n: usize) {
        self.left = self.left.saturating_sub(n as u64);
        self.inner.consume(n);
    }
}

impl<R: BufRead> Read for Rationed<R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let n = self.fill_buf()?.read(out)?;
        self.consume(n);
        Ok(n)
    }
}

type Xml = Reader<Rationed<BufReader<File>>>;

/// Reads the elements of a file, up to its appended data.
pub(super) fn parse(path: &Path) -> Result<Header, InputError> {
    let (file, _) = open_regular(path, &Place::file(path))?;
    let mut xml =
        Reader::from_reader(Rationed { inner: BufReader::with_capacity(1 << 16, file), left: MAX_XML_BYTES });
    let mut open: Vec<String> = Vec::new();
    let mut header = Header {
        byte_order: ByteOrder::Little,
        word_bytes: 4,
        is_compressed: false,
        points: [0; 3],
        spacing: [1.0; 3],
        active_of_points: None,
        active_of_cells: None,
        arrays: Vec::new(),
        appended: None,
        appended_offsets: Vec::new(),
    };
    let mut pieces = 0;
    let mut buffer = Vec::new();
    loop {
        buffer.clear();
        let event = xml.read_event_into(&mut buffer);
        let at = xml.buffer_position();
        let broken = |problem: String| InputError::Header {
            place: Place::part(path, format!("byte {at}")),
            problem,
            remedy: "save the file again as VTK XML image data (.vti)".to_owned(),
        };
        match event.map_err(|e| broken(format!("this is no whole XML ({e})")))? {
            Event::Start(start) => {
                let element = Element { path, at, start: &start };
                let inside = open.last().map(String::as_str);
                element.note(&mut header, inside, &mut pieces, Some(at))?;
                let name = start.name().as_ref().to_owned();
                if name == "AppendedData" {
                    let is_base64 = element.is_base64()?;
                    let offset = underscore(&mut xml).ok_or_else(|| {
                        broken("<AppendedData> does not begin with an underscore".to_owned())
                    })?;
                    header.appended = Some(Appended { offset, is_base64 });
                    break;
                }
                if name == "DataArray" {
                    pass_over(&mut xml).map_err(|e| broken(format!("the values do not end ({e})")))?;
                }
                if open.len() == MAX_DEPTH {
                    return Err(broken(format!("more than {MAX_DEPTH} elements within elements")));
                }
                open.push(name);
            }
            Event::Empty(start) => {
                let element = Element { path, at, start: &start };
                element.note(&mut header, open.last().map(String::as_str), &mut pieces, None)?;
            }
            Event::End(_) => {
                open.pop();
            }
            Event::DocType(_) => return Err(broken("a document type has no place in a VTK file".to_owned())),
            Event::Eof if open.is_empty() => break,
            Event::Eof => return Err(broken("the file ends within its XML".to_owned())),
            _ => {}
        }
    }
    if pieces == 0 {
        return Err(InputError::Header {
            place: Place::file(path),
            problem: "there is no <Piece> in an <ImageData>".to_owned(),
            remedy: "save the file again as VTK XML image data (.vti)".to_owned(),
        });
    }
    Ok(header)
}

/// Passes over the text of an element. It does not count as XML.
fn pass_over(xml: &mut Xml) -> std::io::Result<()> {
    loop {
        xml.get_mut().left = MAX_XML_BYTES;
        let mut stream = xml.stream();
        let buffer = stream.fill_buf()?;
        let text = buffer.iter().position(|b| *b == b'<');
        let n = text.unwrap_or(buffer.len());
        if n == 0 {
            return Ok(());
        }
        stream.consume(n);
    }
}

/// Passes over white space and the underscore behind it; the offset that follows.
fn underscore(xml: &mut Xml) -> Option<u64> {
    let mut byte = [b' '];
    while byte[0].is_ascii_whitespace() {
        xml.stream().read_exact(&mut byte).ok()?;
    }
    (byte[0] == b'_').then(|| xml.buffer_position())
}

/// One element with its attributes.
struct Element<'a> {
    path: &'a Path,
    at: u64,
    start: &'a BytesStart<'a>,
}

impl Element<'_> {
    fn name(&self) -> String {
        self.start.name().as_ref().to_owned()
    }

    fn place(&self) -> Place {
        Place::part(self.path, format!("<{}> before byte {}", shown(&self.name()).trim_matches('`'), self.at))
    }

    /// An attribute's value as written.
    fn attribute(&self, name: &str) -> Result<Option<String>, InputError> {
        for attribute in self.start.attributes() {
            let attribute = attribute.map_err(|e| InputError::Header {
                place: self.place(),
                problem: format!("an attribute is no XML ({e})"),
                remedy: "write NAME=\"VALUE\"".to_owned(),
            })?;
            if attribute.key.as_ref() == name {
                return Ok(Some(attribute.value.into_owned()));
            }
        }
        Ok(None)
    }

    fn malformed(&self, name: &str, value: Option<&str>, wanted: &str) -> InputError {
        let problem = match value {
            Some(value) => format!("`{name}` is {}", shown(value)),
            None => format!("there is no `{name}`"),
        };
        InputError::Header { place: self.place(), problem, remedy: format!("wanted: {wanted}") }
    }

    fn unsupported(&self, name: &str, value: &str, supported: &str) -> InputError {
        InputError::Unsupported {
            place: self.place(),
            found: format!("`{name}` {}", shown(value)),
            supported: supported.to_owned(),
        }
    }

    /// Enters what the element says. `inside` is the element around it, `text` where its text begins, if it has one.
    fn note(
        &self,
        header: &mut Header,
        inside: Option<&str>,
        pieces: &mut u32,
        text: Option<u64>,
    ) -> Result<(), InputError> {
        // Arrays of any kind: those that are not read bound those that are.
        if matches!(self.start.name().as_ref(), "DataArray" | "Array")
            && self.attribute("format")?.as_deref() == Some("appended")
        {
            header.appended_offsets.push(self.number("offset", None)?);
        }
        match (inside, self.start.name().as_ref()) {
            (None, "VTKFile") => self.file(header),
            (None, _) => {
                let (name, wanted) = (self.name(), "<VTKFile type=\"ImageData\">");
                Err(self.unsupported("the root element", &name, wanted))
            }
            (Some("VTKFile"), "ImageData") => self.image(header),
            (Some("ImageData"), "Piece") => {
                *pieces += 1;
                self.piece(header, *pieces)
            }
            (Some("Piece"), "PointData") => {
                header.active_of_points = self.attribute("Scalars")?;
                Ok(())
            }
            (Some("Piece"), "CellData") => {
                header.active_of_cells = self.attribute("Scalars")?;
                Ok(())
            }
            (Some("PointData"), "DataArray") => self.array(header, Association::Points, text),
            (Some("CellData"), "DataArray") => self.array(header, Association::Cells, text),
            _ => Ok(()),
        }
    }

    fn file(&self, header: &mut Header) -> Result<(), InputError> {
        let kind = self.attribute("type")?;
        if kind.as_deref() != Some("ImageData") {
            return Err(self.unsupported("type", &kind.unwrap_or_default(), "ImageData"));
        }
        header.byte_order = match self.attribute("byte_order")?.as_deref() {
            None | Some("LittleEndian") => ByteOrder::Little,
            Some("BigEndian") => ByteOrder::Big,
            other => return Err(self.malformed("byte_order", other, "LittleEndian or BigEndian")),
        };
        header.word_bytes = match self.attribute("header_type")?.as_deref() {
            None | Some("UInt32") => 4,
            Some("UInt64") => 8,
            other => return Err(self.malformed("header_type", other, "UInt32 or UInt64")),
        };
        header.is_compressed = match self.attribute("compressor")?.as_deref() {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                let supported = "vtkZLibDataCompressor, or none; save the file with one of them";
                return Err(self.unsupported("compressor", other, supported));
            }
        };
        Ok(())
    }

    fn image(&self, header: &mut Header) -> Result<(), InputError> {
        header.points = self.extent("WholeExtent")?;
        let steps = self.attribute("TimeValues")?.map_or(1, |values| values.split_whitespace().count());
        if steps > 1 {
            return Err(InputError::Unsupported {
                place: self.place(),
                found: format!("a file of {steps} time steps (`TimeValues`)"),
                supported: "one time step; write each to a file of its own and give them in their order"
                    .to_owned(),
            });
        }
        if let Some(spacing) = self.attribute("Spacing")? {
            let wanted = "three positive, finite lengths, the spacing along x, y and z";
            let numbers: Result<Vec<f64>, _> = spacing.split_whitespace().map(str::parse).collect();
            let numbers: Option<[f64; 3]> = numbers.ok().and_then(|n| n.try_into().ok());
            let usable = numbers.filter(|n| n.iter().all(|s| s.is_finite() && *s > 0.0));
            header.spacing = usable.ok_or_else(|| self.malformed("Spacing", Some(&spacing), wanted))?;
        }
        Ok(())
    }

    fn piece(&self, header: &Header, pieces: u32) -> Result<(), InputError> {
        if pieces > 1 || self.extent("Extent")? != header.points {
            let found = self.attribute("Extent")?.unwrap_or_default();
            return Err(self.unsupported("Extent", &found, "one piece that is the whole image"));
        }
        Ok(())
    }

    /// Points along each axis of an extent `x0 x1 y0 y1 z0 z1`.
    fn extent(&self, name: &str) -> Result<[u32; 3], InputError> {
        let value = self.attribute(name)?;
        let points = |value: &str| {
            let ends: Vec<i64> = value.split_whitespace().map(str::parse).collect::<Result<_, _>>().ok()?;
            let [x0, x1, y0, y1, z0, z1] = ends[..] else { return None };
            let count = |low: i64, high: i64| {
                let count = high.checked_sub(low)?.checked_add(1)?;
                u32::try_from(count).ok().filter(|n| *n > 0)
            };
            Some([count(x0, x1)?, count(y0, y1)?, count(z0, z1)?])
        };
        let wanted = "six whole numbers, the first and the last point along x, y and z";
        value.as_deref().and_then(points).ok_or_else(|| self.malformed(name, value.as_deref(), wanted))
    }

    fn array(
        &self,
        header: &mut Header,
        association: Association,
        text: Option<u64>,
    ) -> Result<(), InputError> {
        let kind = self.attribute("type")?.unwrap_or_default();
        let types = "Int8, UInt8, Int16, UInt16, Int32, UInt32, Int64, UInt64, Float32, Float64";
        let format = self.attribute("format")?;
        let wanted = "ascii, binary or appended";
        let format = match (format.as_deref(), text) {
            (Some("appended"), _) => Format::Appended(self.number("offset", None)?),
            (Some("ascii"), Some(at)) => Format::Ascii(at),
            (Some("binary"), Some(at)) => Format::Binary(at),
            (Some("ascii" | "binary"), None) => {
                return Err(self.malformed("format", format.as_deref(), "values in the element"));
            }
            (other, _) => return Err(self.malformed("format", other, wanted)),
        };
        // Strings and bits in other arrays are no reason to refuse the array that is the volume.
        let Some(stored) = sample_type(&kind) else {
            let names_it =
                |active: &Option<String>, name: &Option<String>| active.is_some() && active != name;
            let name = self.attribute("Name")?;
            let active = match association {
                Association::Points => &header.active_of_points,
                Association::Cells => &header.active_of_cells,
            };
            return if names_it(active, &name) {
                Ok(())
            } else {
                Err(self.unsupported("type", &kind, types))
            };
        };
        let components = self.number("NumberOfComponents", Some(1))?;
        header.arrays.push(Array {
            place: self.place(),
            association,
            name: self.attribute("Name")?.unwrap_or_default(),
            stored,
            components: u32::try_from(components).unwrap_or(u32::MAX),
            format,
        });
        Ok(())
    }

    fn number(&self, name: &str, default: Option<u64>) -> Result<u64, InputError> {
        match (self.attribute(name)?, default) {
            (None, Some(default)) => Ok(default),
            (value, _) => {
                let number = value.as_deref().and_then(|v| v.trim().parse().ok());
                number.ok_or_else(|| self.malformed(name, value.as_deref(), "a whole number, 0 or more"))
            }
        }
    }

    fn is_base64(&self) -> Result<bool, InputError> {
        match self.attribute("encoding")?.as_deref() {
            Some("base64") => Ok(true),
            Some("raw") => Ok(false),
            other => Err(self.malformed("encoding", other, "raw or base64")),
        }
    }
}
