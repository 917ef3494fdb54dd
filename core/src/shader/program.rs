//! The modules of a shader, and their variables.

use cvr_shaders::Template;

/// A part of a shader's text.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Module {
    /// A file.
    File(Template),
    /// Text that is made for a view.
    Generated {
        /// Purpose, for the origin comment.
        purpose: &'static str,
        /// The text.
        source: String,
    },
}

impl Module {
    /// The file, or the purpose of the text.
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

/// A variable that modules use. The generator declares it if a module uses it.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub enum Variable {
    /// `inputs.<name>`: a struct that a module declares. One buffer holds all uniforms of a shader.
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
    /// A 2-D texture with four single-precision numbers per texel, read by `textureLoad`.
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

/// A shader without its voxel source: the request of a template, or of a renderer for a view. Equal programs with equal
/// sources give equal shaders.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Program {
    /// Modules that are always part of the text.
    pub modules: Vec<Module>,
    /// Modules that are included if the shader uses their declarations. Shared modules ([`cvr_shaders::ALL`]) need not
    /// be listed if no other module declares the same name.
    pub offered: Vec<Module>,
    /// Entry point, which a module declares.
    pub entry: &'static str,
    /// Variables that modules may use. Unused ones are not declared.
    pub variables: Vec<Variable>,
}

impl Program {
    /// The program of a template that dumps voxels (such as [`cvr_shaders::DUMP`]).
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
