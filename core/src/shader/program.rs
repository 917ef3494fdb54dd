//! What the modules of a shader are, and what they read and write beside voxels.

use cvr_shaders::Template;

/// A part of a shader's text.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Module {
    /// A file.
    File(Template),
    /// Text that is made for a view.
    Generated {
        /// What for; its origin comment says so.
        purpose: &'static str,
        /// The text.
        source: String,
    },
}

impl Module {
    /// The file, or what the text is for.
    #[must_use]
    pub const fn name(&self) -> &str {
        match self {
            Self::File(template) => template.file,
            Self::Generated { purpose, .. } => purpose,
        }
    }

    /// The text.
    #[must_use]
    pub fn source(&self) -> &str {
        match self {
            Self::File(template) => template.source,
            Self::Generated { source, .. } => source,
        }
    }
}

impl From<Template> for Module {
    fn from(template: Template) -> Self {
        Self::File(template)
    }
}

/// A name that modules use and the generator declares, where one of them uses it.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub enum Variable {
    /// `inputs.<name>`: a struct that a module declares. All uniforms of a shader lie in one buffer.
    Uniform {
        /// Name.
        name: &'static str,
        /// Name of the struct.
        wgsl_type: &'static str,
    },
    /// A storage buffer.
    Storage {
        /// Name.
        name: &'static str,
        /// Type, as `array<u32>`.
        wgsl_type: &'static str,
        /// Whether the shader writes it.
        written: bool,
    },
    /// A 2-D texture of four numbers a texel in single precision, read by `textureLoad`.
    Table {
        /// Name.
        name: &'static str,
        /// Its rows.
        rows: u32,
    },
}

impl Variable {
    /// A storage buffer that is only read.
    #[must_use]
    pub const fn read(name: &'static str, wgsl_type: &'static str) -> Self {
        Self::Storage { name, wgsl_type, written: false }
    }

    /// A storage buffer that is written.
    #[must_use]
    pub const fn written(name: &'static str, wgsl_type: &'static str) -> Self {
        Self::Storage { name, wgsl_type, written: true }
    }

    /// Its name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Uniform { name, .. } | Self::Storage { name, .. } | Self::Table { name, .. } => name,
        }
    }
}

/// A shader but for its voxels: what a template, or a renderer for a view, asks of the generator. Equal programs over equal
/// sources are equal shaders.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Program {
    /// Modules that stand in the text.
    pub modules: Vec<Module>,
    /// Modules that stand in it where something uses what they declare. Shared modules ([`cvr_shaders::ALL`]) that are the
    /// only ones to declare a name need no mention.
    pub offered: Vec<Module>,
    /// Entry point, which a module declares.
    pub entry: &'static str,
    /// What modules may use; what none of them does is not declared.
    pub variables: Vec<Variable>,
}

impl Program {
    /// The program of a template that dumps voxels ([`cvr_shaders::DUMP`] or one like it).
    #[must_use]
    pub fn dump(template: Template) -> Self {
        Self {
            modules: vec![template.into()],
            offered: Vec::new(),
            entry: "dump",
            variables: vec![
                Variable::Uniform { name: "dumped", wgsl_type: "Dumped" },
                Variable::written("dump_values", "array<f32>"),
            ],
        }
    }
}
