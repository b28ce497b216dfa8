//! A scene drawn by a Vulkan driver: for each pixel the number of the triangle that it sees and its depth.

use nalgebra::Point3;
use openbench_core::Pose3;
use openbench_scene::Scene;
use wgpu::util::DeviceExt;

/// Nearest depth that is drawn, metres.
const NEAR: f64 = 0.001;
/// Bytes of a corner: position, plane, texture coordinates, triangle, material.
const CORNER: u64 = 40;

/// Part of a pinhole camera's picture.
#[derive(Debug, Clone, Copy)]
pub struct Lens {
    /// The camera: x forward, y left, z up, in `map`.
    pub pose: Pose3,
    /// Columns and rows.
    pub size: (u32, u32),
    /// Focal length, pixels.
    pub focal_length: f64,
    /// Column and row, in pixels, through whose middle (whole numbers) the optical axis passes.
    pub axis: [f64; 2],
    /// Depth beyond which nothing is seen, metres.
    pub range: f64,
}

/// What a pixel sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Index into the scene's triangles.
    pub triangle: u32,
    /// Along the optical axis, metres.
    pub depth: f32,
}

/// A driver with a scene's materials.
pub struct Rasterizer {
    name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipeline: wgpu::RenderPipeline,
    masks: wgpu::Buffer,
    holes: wgpu::Buffer,
}

impl Rasterizer {
    /// On the first Vulkan driver that computes on the processor; `None` if there is none.
    pub fn new(scene: &Scene) -> Option<Self> {
        let mut options = wgpu::InstanceDescriptor::new_without_display_handle();
        options.backends = wgpu::Backends::VULKAN;
        let instance = wgpu::Instance::new(options);
        let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN));
        let adapter = adapters
            .into_iter()
            .find(|a| a.get_info().device_type == wgpu::DeviceType::Cpu)?;
        let limits = wgpu::DeviceDescriptor {
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&limits)).ok()?;
        let (masks, holes) = holes(scene);
        let storage = |contents: &[u32]| {
            let contents: Vec<u8> = contents.iter().flat_map(|w| w.to_le_bytes()).collect();
            let usage = wgpu::BufferUsages::STORAGE;
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: None,
                contents: &contents,
                usage,
            })
        };
        let info = adapter.get_info();
        Some(Self {
            name: format!("{} ({} {})", info.name, info.driver, info.driver_info),
            pipeline: pipeline(&device),
            masks: storage(&masks),
            holes: storage(&holes),
            device,
            queue,
        })
    }

    /// The driver.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What each pixel sees, rows from the top; `None` for nothing.
    pub fn draw(&self, scene: &Scene, lens: &Lens) -> Vec<Option<Sight>> {
        let corners = corners(scene, lens);
        let buffer = |contents: &[u8], usage| {
            self.device
                .create_buffer_init(&wgpu::util::BufferInitDescriptor {
                    label: None,
                    contents,
                    usage,
                })
        };
        let count = corners.len() as u64 / CORNER;
        let vertices = buffer(&corners, wgpu::BufferUsages::VERTEX);
        let uniform = buffer(&uniform(lens), wgpu::BufferUsages::UNIFORM);
        let mut entries = Vec::new();
        for (binding, buffer) in (0..).zip([&uniform, &self.masks, &self.holes]) {
            entries.push(wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            });
        }
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let target = |format| self.target(lens.size, format);
        let (triangle, depth) = (
            target(wgpu::TextureFormat::R32Uint),
            target(wgpu::TextureFormat::R32Float),
        );
        let order = target(wgpu::TextureFormat::Depth32Float);
        let views = [&triangle, &depth, &order].map(|t| t.create_view(&Default::default()));
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let ops = wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                store: wgpu::StoreOp::Store,
            };
            let color = |view| {
                Some(wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target: None,
                    ops,
                })
            };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[color(&views[0]), color(&views[1])],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &views[2],
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(0.0),
                        store: wgpu::StoreOp::Discard,
                    }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            if count > 0 {
                pass.set_vertex_buffer(0, vertices.slice(..));
                pass.draw(0..count as u32, 0..1);
            }
        }
        let [triangles, depths] =
            [&triangle, &depth].map(|texture| self.copy_out(&mut encoder, texture));
        self.queue.submit([encoder.finish()]);
        let triangles = self.read(&triangles, lens.size);
        let depths = self.read(&depths, lens.size);
        let sight = |(name, depth): (u32, u32)| {
            (name > 0).then(|| Sight {
                triangle: name - 1,
                depth: f32::from_bits(depth),
            })
        };
        triangles.into_iter().zip(depths).map(sight).collect()
    }

    fn target(&self, (width, height): (u32, u32), format: wgpu::TextureFormat) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    fn copy_out(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
    ) -> wgpu::Buffer {
        let size = texture.size();
        let row = bytes_per_row(size.width);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row) * u64::from(size.height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row),
            rows_per_image: None,
        };
        let to = wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout,
        };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), to, size);
        buffer
    }

    /// The words of a picture that was copied out.
    fn read(&self, buffer: &wgpu::Buffer, (width, height): (u32, u32)) -> Vec<u32> {
        buffer.map_async(wgpu::MapMode::Read, .., |_| ());
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .expect("the driver finishes its work");
        let bytes = buffer
            .get_mapped_range(..)
            .expect("a buffer that was mapped")
            .to_vec();
        let rows = bytes
            .chunks_exact(bytes_per_row(width) as usize)
            .take(height as usize);
        let word = |b: &[u8]| u32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        rows.flat_map(|row| row[..4 * width as usize].chunks_exact(4).map(word))
            .collect()
    }
}

/// Rows are copied out at multiples of 256 bytes.
fn bytes_per_row(width: u32) -> u32 {
    (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

fn pipeline(device: &wgpu::Device) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::include_wgsl!("coverage.wgsl"));
    let attributes =
        wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Uint32x2];
    let layout = wgpu::VertexBufferLayout {
        array_stride: CORNER,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &attributes,
    };
    let target = |format| {
        Some(wgpu::ColorTargetState {
            format,
            blend: None,
            write_mask: wgpu::ColorWrites::ALL,
        })
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("project"),
            compilation_options: Default::default(),
            buffers: &[Some(layout)],
        },
        // Both sides of a triangle are seen.
        primitive: wgpu::PrimitiveState {
            cull_mode: None,
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: wgpu::TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("see"),
            compilation_options: Default::default(),
            targets: &[
                target(wgpu::TextureFormat::R32Uint),
                target(wgpu::TextureFormat::R32Float),
            ],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// For each material where its holes begin, columns, rows, 0; and the holes, a bit each.
fn holes(scene: &Scene) -> (Vec<u32>, Vec<u32>) {
    let (mut masks, mut holes) = (Vec::new(), Vec::new());
    for material in &scene.materials {
        let texture = material
            .texture
            .filter(|_| material.cutout)
            .map(|t| &scene.textures[t.0 as usize]);
        let Some(texture) = texture else {
            masks.extend([0; 4]);
            continue;
        };
        masks.extend([holes.len() as u32, texture.width, texture.height, 0]);
        for texels in texture.rgba.chunks(4 * 32) {
            let bit = |(i, texel): (usize, &[u8])| u32::from(texel[3] < 128) << i;
            holes.push(texels.chunks_exact(4).enumerate().map(bit).sum());
        }
    }
    // Buffers cannot be empty.
    holes.push(0);
    masks.extend([0; 4]);
    (masks, holes)
}

/// The corners of all triangles that are not wholly outside the picture, relative to the camera. Computed in double precision, so that
/// places far from the origin lose nothing.
fn corners(scene: &Scene, lens: &Lens) -> Vec<u8> {
    let to_camera = lens.pose.inverse();
    let place = |p: [f32; 3]| {
        let p = to_camera * Point3::from(p.map(f64::from));
        [-p.y, p.z, p.x]
    };
    let places: Vec<[f64; 3]> = scene.vertices.iter().map(|v| place(v.position)).collect();
    let sides = sides(lens);
    let mut bytes = Vec::new();
    for (name, triangle) in (1_u32..).zip(&scene.triangles) {
        let corners = triangle.corners.map(|i| places[i as usize]);
        if sides
            .iter()
            .any(|side| corners.iter().all(|c| dot(*side, *c) < 0.0))
        {
            continue;
        }
        let plane = plane(corners);
        for (i, corner) in triangle.corners.into_iter().zip(corners) {
            let uv = scene.vertices[i as usize].uv;
            let numbers = corner.iter().chain(&plane).map(|c| *c as f32).chain(uv);
            numbers.for_each(|n| bytes.extend(n.to_le_bytes()));
            [name, triangle.material.0]
                .iter()
                .for_each(|n| bytes.extend(n.to_le_bytes()));
        }
    }
    bytes
}

/// The vector whose product with a ray (x, y, 1) is 1 over the depth at which the ray meets the triangle's plane; zero for a plane seen from its edge.
fn plane([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let edge = |p: [f64; 3]| [0, 1, 2].map(|i| p[i] - a[i]);
    let (e, f) = (edge(b), edge(c));
    let normal = [
        e[1] * f[2] - e[2] * f[1],
        e[2] * f[0] - e[0] * f[2],
        e[0] * f[1] - e[1] * f[0],
    ];
    let distance = dot(normal, a);
    let plane = normal.map(|n| n / distance);
    if plane.iter().all(|p| p.abs() < 1e30) {
        plane
    } else {
        [0.0; 3]
    }
}

/// What a lens looks at lies on the positive side of each of these planes through the eye; half a pixel is left on all sides.
fn sides(lens: &Lens) -> [[f64; 3]; 5] {
    let f = lens.focal_length;
    let reach = |axis: f64, pixels: u32| ((-1.0 - axis) / f, (f64::from(pixels) - axis) / f);
    let ((left, right), (top, bottom)) = (
        reach(lens.axis[0], lens.size.0),
        reach(lens.axis[1], lens.size.1),
    );
    [
        [1.0, 0.0, -left],
        [-1.0, 0.0, right],
        [0.0, -1.0, -top],
        [0.0, 1.0, bottom],
        [0.0, 0.0, 1.0],
    ]
}

fn uniform(lens: &Lens) -> Vec<u8> {
    let (width, height) = (f64::from(lens.size.0), f64::from(lens.size.1));
    let f = lens.focal_length;
    let [u, v] = lens.axis;
    let numbers = [
        2.0 * f / width,
        2.0 * f / height,
        (2.0 * u + 1.0) / width - 1.0,
        1.0 - (2.0 * v + 1.0) / height,
        NEAR,
        lens.range,
        -u / f,
        v / f,
        1.0 / f,
        -1.0 / f,
        0.0,
        0.0,
    ];
    numbers
        .iter()
        .flat_map(|n| (*n as f32).to_le_bytes())
        .collect()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
