//! Adapters: which exist, and which one is taken.

use std::str::FromStr;

/// Graphics interface through which a device is driven.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Backend {
    /// Vulkan.
    Vulkan,
    /// Metal.
    Metal,
    /// DX12.
    Dx12,
    /// OpenGL and OpenGL ES.
    Gl,
}

impl Backend {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Vulkan, Self::Metal, Self::Dx12, Self::Gl];

    /// Name in records, and as a choice: `vulkan`, `metal`, `dx12`, `gl`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Vulkan => "vulkan",
            Self::Metal => "metal",
            Self::Dx12 => "dx12",
            Self::Gl => "gl",
        }
    }

    pub(crate) const fn flag(self) -> wgpu::Backends {
        match self {
            Self::Vulkan => wgpu::Backends::VULKAN,
            Self::Metal => wgpu::Backends::METAL,
            Self::Dx12 => wgpu::Backends::DX12,
            Self::Gl => wgpu::Backends::GL,
        }
    }
}

/// Which adapter to open.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum DeviceChoice {
    /// The best: Vulkan, Metal or DX12 before GL; discrete before integrated, virtual, software.
    #[default]
    Auto,
    /// The best of one backend.
    Backend(Backend),
    /// The best among those whose name contains this text, in any case.
    Named(String),
    /// The adapter at this index of [`list_adapters`].
    Index(usize),
}

impl FromStr for DeviceChoice {
    type Err = std::convert::Infallible;

    /// `auto`, the name of a backend, `#` and an index of the list, or a part of a name.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if text.eq_ignore_ascii_case("auto") {
            return Ok(Self::Auto);
        }
        if let Some(backend) = Backend::ALL.into_iter().find(|b| text.eq_ignore_ascii_case(b.name())) {
            return Ok(Self::Backend(backend));
        }
        let index = text.strip_prefix('#').and_then(|digits| digits.parse().ok());
        Ok(index.map_or_else(|| Self::Named(text.to_owned()), Self::Index))
    }
}

impl std::fmt::Display for DeviceChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Backend(backend) => f.write_str(backend.name()),
            Self::Named(name) => f.write_str(name),
            Self::Index(index) => write!(f, "#{index}"),
        }
    }
}

/// Kind of an adapter, best first.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceKind {
    /// A card with memory of its own.
    Discrete,
    /// Shares the processor's memory.
    Integrated,
    /// Hosted in a virtual machine.
    Virtual,
    /// The processor itself.
    Cpu,
    /// The driver does not say.
    Other,
}

impl DeviceKind {
    /// Name used in records: `discrete`, `integrated`, `virtual`, `cpu`, `other`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Discrete => "discrete",
            Self::Integrated => "integrated",
            Self::Virtual => "virtual",
            Self::Cpu => "cpu",
            Self::Other => "other",
        }
    }
}

impl From<wgpu::DeviceType> for DeviceKind {
    fn from(kind: wgpu::DeviceType) -> Self {
        match kind {
            wgpu::DeviceType::DiscreteGpu => Self::Discrete,
            wgpu::DeviceType::IntegratedGpu => Self::Integrated,
            wgpu::DeviceType::VirtualGpu => Self::Virtual,
            wgpu::DeviceType::Cpu => Self::Cpu,
            wgpu::DeviceType::Other => Self::Other,
        }
    }
}

/// Description of an adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// Name of the device.
    pub name: String,
    /// Name of the driver.
    pub driver: String,
    /// Version of the driver, in its own words.
    pub driver_info: String,
    /// `vulkan`, `metal`, `dx12` or `gl`.
    pub backend: String,
    /// Sort of device.
    pub kind: DeviceKind,
}

impl DeviceInfo {
    pub(crate) fn of(adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        Self {
            name: info.name,
            driver: info.driver,
            driver_info: info.driver_info,
            backend: info.backend.to_str().to_owned(),
            kind: info.device_type.into(),
        }
    }

    /// Order of adapters, best first. GL comes last on any device, because its compute support has gaps.
    fn rank(&self) -> (bool, DeviceKind) {
        (self.backend == "gl", self.kind)
    }
}

impl std::fmt::Display for DeviceInfo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({}, {}", self.name, self.backend, self.kind.name())?;
        for text in [&self.driver, &self.driver_info] {
            if !text.is_empty() {
                write!(f, ", {text}")?;
            }
        }
        f.write_str(")")
    }
}

pub(crate) const NATIVE: wgpu::Backends =
    wgpu::Backends::VULKAN.union(wgpu::Backends::METAL).union(wgpu::Backends::DX12);

/// Adapters of some backends. Each call makes an instance, because GL alone costs a context, and most callers never
/// need it.
pub(crate) fn adapters(backends: wgpu::Backends) -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = backends;
    // Validation layers would be part of every timing. WGPU_VALIDATION=1 enables them.
    descriptor.flags = wgpu::InstanceFlags::empty().with_env();
    pollster::block_on(wgpu::Instance::new(descriptor).enumerate_adapters(backends))
}

/// All adapters of this machine, those of GL last. Creates a GL context if GL exists.
#[must_use]
pub fn list_adapters() -> Vec<DeviceInfo> {
    all_adapters().iter().map(DeviceInfo::of).collect()
}

pub(crate) fn all_adapters() -> Vec<wgpu::Adapter> {
    let mut all = adapters(NATIVE);
    all.extend(adapters(wgpu::Backends::GL));
    all
}

/// Index of the adapter to open.
pub(crate) fn choose(choice: &DeviceChoice, infos: &[DeviceInfo]) -> Option<usize> {
    let best = |fits: &dyn Fn(&DeviceInfo) -> bool| {
        (0..infos.len()).filter(|&i| fits(&infos[i])).min_by_key(|&i| infos[i].rank())
    };
    match choice {
        DeviceChoice::Auto => best(&|_| true),
        DeviceChoice::Backend(backend) => best(&|info| info.backend == backend.name()),
        DeviceChoice::Named(name) => {
            let name = name.to_lowercase();
            best(&|info| info.name.to_lowercase().contains(&name))
        }
        DeviceChoice::Index(index) => (*index < infos.len()).then_some(*index),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adapter(name: &str, backend: &str, kind: DeviceKind) -> DeviceInfo {
        let (driver, driver_info) = (String::new(), String::new());
        DeviceInfo { name: name.to_owned(), driver, driver_info, backend: backend.to_owned(), kind }
    }

    #[test]
    fn the_best_adapter_is_taken_and_gl_only_as_a_last_resort() {
        let infos = [
            adapter("llvmpipe", "vulkan", DeviceKind::Cpu),
            adapter("Radeon 780M", "vulkan", DeviceKind::Integrated),
            adapter("GeForce 3090", "vulkan", DeviceKind::Discrete),
            adapter("GeForce 3090", "gl", DeviceKind::Discrete),
        ];
        assert_eq!(choose(&DeviceChoice::Auto, &infos), Some(2));
        assert_eq!(choose(&DeviceChoice::Auto, &infos[..2]), Some(1));
        assert_eq!(choose(&DeviceChoice::Auto, &[infos[3].clone(), infos[0].clone()]), Some(1));
        assert_eq!(choose(&DeviceChoice::Named("radeon".to_owned()), &infos), Some(1));
        assert_eq!(choose(&DeviceChoice::Named("geforce".to_owned()), &infos), Some(2));
        assert_eq!(choose(&DeviceChoice::Named("arc".to_owned()), &infos), None);
        assert_eq!(choose(&DeviceChoice::Backend(Backend::Gl), &infos), Some(3));
        assert_eq!(choose(&DeviceChoice::Backend(Backend::Vulkan), &infos), Some(2));
        assert_eq!(choose(&DeviceChoice::Backend(Backend::Metal), &infos), None);
        assert_eq!(choose(&DeviceChoice::Index(3), &infos), Some(3));
        assert_eq!(choose(&DeviceChoice::Index(4), &infos), None);
        assert_eq!(choose(&DeviceChoice::Auto, &[]), None);
    }

    #[test]
    fn choices_are_written_as_they_are_read() {
        for (text, choice) in [
            ("auto", DeviceChoice::Auto),
            ("gl", DeviceChoice::Backend(Backend::Gl)),
            ("vulkan", DeviceChoice::Backend(Backend::Vulkan)),
            ("#2", DeviceChoice::Index(2)),
            ("#two", DeviceChoice::Named("#two".to_owned())),
            ("llvmpipe", DeviceChoice::Named("llvmpipe".to_owned())),
        ] {
            assert_eq!(text.parse::<DeviceChoice>(), Ok(choice.clone()));
            assert_eq!(choice.to_string(), text);
        }
    }
}
