#include <alpenglow/prt/part_file.hpp>

#include <alpenglow/prt/hash.hpp>
#include <alpenglow/prt/transfer_file.hpp>

#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <limits>
#include <vector>

namespace alpenglow::prt {
namespace {

static_assert(std::endian::native == std::endian::little, "part files are written as they stand");

constexpr std::array<char, 8> magic{'A', 'G', 'B', 'A', 'K', 'E', 'P', 'T'};
constexpr std::uint32_t version = 1;

struct PartHeader {
    std::array<char, 8> magic_value = magic;
    std::uint32_t version_value = version;
    std::uint32_t order = 0;
    std::uint64_t checksum = 0; // of the file with this field zero
    std::uint32_t transport = 0;
    std::uint32_t sampling = 0;
    std::uint64_t rays = 0;
    double max_error = 0.0;
    std::uint64_t gather_rays_setting = 0;
    std::int32_t max_bounces = 0;
    std::uint32_t colour = 0;
    double stop_energy = 0.0;
    float default_albedo = 0.0F;
    std::uint32_t reserved = 0;
    std::uint64_t seed = 0;
    std::uint64_t mesh_hash = 0;
    std::uint64_t settings_hash = 0;
    std::uint64_t first = 0;
    std::uint64_t count = 0;
    std::uint64_t hit_counts = 0;
    std::uint64_t hits = 0;
    std::uint64_t shadow_rays = 0;
    std::uint64_t gather_rays = 0;
    std::uint64_t inside_points = 0;
    double cpu_s = 0.0;
    double tracing_cpu_s = 0.0;
};
static_assert(sizeof(PartHeader) == 176);
static_assert(sizeof(GatherHit) == 8);

constexpr std::array<char, 8> field_magic{'A', 'G', 'B', 'A', 'K', 'E', 'F', 'P'};

struct FieldPartHeader {
    std::array<char, 8> magic_value = field_magic;
    std::uint32_t version_value = version;
    std::uint32_t kind = 0;
    std::uint64_t checksum = 0; // of the file with this field zero
    std::uint64_t input_hash = 0;
    std::uint64_t settings_hash = 0;
    std::uint64_t first = 0;
    std::uint64_t count = 0;
    std::uint64_t values = 0;
    std::uint64_t inside = 0;
    std::uint64_t rays = 0;
    std::uint64_t dark_points = 0;
    double cpu_s = 0.0;
    // Settings, of the kind.
    std::uint32_t transport = 0;
    std::int32_t order = 0;
    std::int32_t out_order = 0;
    std::int32_t max_bounces = 0;
    std::uint64_t rays_setting = 0; // a volume's directions
    std::uint64_t gather_rays = 0;
    double stop_energy = 0.0;
    std::uint64_t seed = 0;
    float albedo = 0.0F;
    float specular = 0.0F;
    float phong_exponent = 0.0F;
    std::uint32_t bounce = 0;
    glm::uvec3 grid_size{0};
    glm::vec3 grid_origin_m{0.0F};
    glm::vec3 grid_step_m{0.0F};
    std::uint32_t reserved = 0;
};
static_assert(sizeof(FieldPartHeader) == 200);

using Bytes = std::span<const std::byte>;

// What follows the header in a file.
std::vector<Bytes> data_of(const BakePart& part) {
    return {std::as_bytes(std::span(part.direct)), std::as_bytes(std::span(part.visibility)),
            std::as_bytes(std::span(part.variance)), std::as_bytes(std::span(part.hit_counts)),
            std::as_bytes(std::span(part.hits))};
}
std::vector<Bytes> data_of(const FieldPart& part) {
    return {std::as_bytes(std::span(part.values)), std::as_bytes(std::span(part.inside))};
}

// Of a header, its own field zero, and what follows it.
template <class Header>
std::uint64_t checksum_of(Header header, const std::vector<Bytes>& data) {
    header.checksum = 0;
    Hasher hasher;
    hasher.add(std::as_bytes(std::span(&header, 1)));
    for (const Bytes values : data) {
        hasher.add(values);
    }
    return hasher.digest();
}

template <class Header>
Status write_part(const std::filesystem::path& path, Header& header, std::vector<Bytes> data) {
    header.checksum = checksum_of(header, data);
    data.insert(data.begin(), std::as_bytes(std::span(&header, 1)));
    return write_file_atomically(path, data);
}

// Fills vectors of known sizes; false where the file ends early.
template <class... Values>
bool read_all(std::ifstream& file, Values&... values) {
    const auto read = [&](std::span<std::byte> to) {
        return to.empty() ||
               file.read(reinterpret_cast<char*>(to.data()), static_cast<std::streamsize>(to.size())).good();
    };
    return (read(std::as_writable_bytes(std::span(values))) && ...);
}

} // namespace

Status save_part(const BakeSettings& settings, const BakePart& part, const std::filesystem::path& path) {
    PartHeader header;
    header.order = static_cast<std::uint32_t>(settings.order);
    header.transport = static_cast<std::uint32_t>(settings.transport);
    header.sampling = static_cast<std::uint32_t>(settings.sampling);
    header.rays = settings.rays;
    header.max_error = settings.max_error;
    header.gather_rays_setting = settings.gather_rays;
    header.max_bounces = settings.max_bounces;
    header.colour = settings.colour ? 1 : 0;
    header.stop_energy = settings.stop_energy;
    header.default_albedo = settings.default_albedo;
    header.seed = settings.seed;
    header.mesh_hash = part.mesh_hash;
    header.settings_hash = part.settings_hash;
    header.first = part.first;
    header.count = part.count;
    header.hit_counts = part.hit_counts.size();
    header.hits = part.hits.size();
    header.shadow_rays = part.shadow_rays;
    header.gather_rays = part.gather_rays;
    header.inside_points = part.inside_points;
    header.cpu_s = part.cpu_s;
    header.tracing_cpu_s = part.tracing_cpu_s;
    return write_part(path, header, data_of(part));
}

Result<SavedPart> load_part(const std::filesystem::path& path) {
    const auto wrong = [&](const std::string& what, const std::string& expected) {
        return Error{what, path.string(), expected};
    };
    std::error_code code;
    const std::uint64_t bytes = std::filesystem::file_size(path, code);
    std::ifstream file(path, std::ios::binary);
    if (code || !file) {
        return wrong("cannot be read", "a part written by alpenglow-bake --shard");
    }
    PartHeader header;
    if (bytes < sizeof header || !file.read(reinterpret_cast<char*>(&header), sizeof header) ||
        header.magic_value != magic) {
        return wrong("is not a part of a bake", "a part written by alpenglow-bake --shard");
    }
    if (header.version_value != version) {
        return wrong("version is " + std::to_string(header.version_value), std::to_string(version));
    }
    const std::uint64_t n = std::uint64_t{header.order} * header.order;
    constexpr std::uint64_t most = std::uint64_t{1} << 40U;
    if (header.order < 1 || header.order > 6 || header.count > most || header.hits > most ||
        (header.hit_counts != 0 && header.hit_counts != header.count) || header.transport > 2 || header.sampling > 3 ||
        bytes != sizeof header + 4 * (header.count * (n + 2) + header.hit_counts) + 8 * header.hits) {
        return wrong("has " + std::to_string(bytes) + " bytes, its header says otherwise", "an undamaged part");
    }
    SavedPart saved;
    BakePart& part = saved.part;
    part.direct.resize(header.count * n);
    part.visibility.resize(header.count);
    part.variance.resize(header.count);
    part.hit_counts.resize(header.hit_counts);
    part.hits.resize(header.hits);
    if (!read_all(file, part.direct, part.visibility, part.variance, part.hit_counts, part.hits)) {
        return wrong("ends early", "an undamaged part");
    }
    if (checksum_of(header, data_of(part)) != header.checksum) {
        return wrong("checksum does not match", "an undamaged part");
    }
    part.mesh_hash = header.mesh_hash;
    part.settings_hash = header.settings_hash;
    part.first = header.first;
    part.count = header.count;
    part.shadow_rays = header.shadow_rays;
    part.gather_rays = header.gather_rays;
    part.inside_points = header.inside_points;
    part.cpu_s = header.cpu_s;
    part.tracing_cpu_s = header.tracing_cpu_s;
    BakeSettings& s = saved.settings;
    s.order = static_cast<int>(header.order);
    s.transport = static_cast<Transport>(header.transport);
    s.sampling = static_cast<Sampling>(header.sampling);
    s.rays = header.rays;
    s.max_error = header.max_error;
    s.gather_rays = header.gather_rays_setting;
    s.max_bounces = header.max_bounces;
    s.colour = header.colour != 0;
    s.stop_energy = header.stop_energy;
    s.default_albedo = header.default_albedo;
    s.seed = header.seed;
    return saved;
}

Status save_field_part(const SavedFieldPart& saved, const std::filesystem::path& path) {
    const FieldPart& part = saved.part;
    FieldPartHeader header;
    header.kind = static_cast<std::uint32_t>(part.kind);
    header.input_hash = part.input_hash;
    header.settings_hash = part.settings_hash;
    header.first = part.first;
    header.count = part.count;
    header.values = part.values.size();
    header.inside = part.inside.size();
    header.rays = part.rays;
    header.dark_points = part.dark_points;
    header.cpu_s = part.cpu_s;
    if (part.kind == TransferKind::glossy) {
        const GlossySettings& s = saved.glossy;
        header.transport = static_cast<std::uint32_t>(s.transport);
        header.order = s.order;
        header.out_order = s.out_order;
        header.max_bounces = s.max_bounces;
        header.rays_setting = s.rays;
        header.gather_rays = s.gather_rays;
        header.stop_energy = s.stop_energy;
        header.seed = s.seed;
        header.albedo = s.default_albedo;
        header.specular = s.specular;
        header.phong_exponent = s.phong_exponent;
    } else if (part.kind == TransferKind::neighbourhood) {
        const NeighbourhoodSettings& s = saved.neighbourhood;
        header.order = s.order;
        header.out_order = s.out_order;
        header.rays_setting = s.rays;
        header.seed = s.seed;
        header.albedo = s.default_albedo;
        header.bounce = s.bounce ? 1 : 0;
        header.grid_size = saved.grid.size;
        header.grid_origin_m = saved.grid.origin_m;
        header.grid_step_m = saved.grid.step_m;
    } else {
        const VolumeSettings& s = saved.volume;
        header.order = s.order;
        header.max_bounces = s.max_bounces;
        header.rays_setting = s.directions;
        header.stop_energy = s.stop_energy;
        header.albedo = s.albedo;
    }
    return write_part(path, header, data_of(part));
}

Result<SavedFieldPart> load_field_part(const std::filesystem::path& path) {
    const auto wrong = [&](const std::string& what, const std::string& expected) {
        return Error{what, path.string(), expected};
    };
    std::error_code code;
    const std::uint64_t bytes = std::filesystem::file_size(path, code);
    std::ifstream file(path, std::ios::binary);
    FieldPartHeader header;
    if (code || !file || bytes < sizeof header || !file.read(reinterpret_cast<char*>(&header), sizeof header) ||
        header.magic_value != field_magic) {
        return wrong("is not a part of a glossy, neighbourhood or volume bake",
                     "a part written by alpenglow-bake --shard");
    }
    if (header.version_value != version) {
        return wrong("version is " + std::to_string(header.version_value), std::to_string(version));
    }
    constexpr std::uint64_t most = std::uint64_t{1} << 40U;
    const auto kind = static_cast<TransferKind>(header.kind);
    if ((kind != TransferKind::glossy && kind != TransferKind::neighbourhood && kind != TransferKind::volume) ||
        header.values > most || header.inside > most || header.transport > 2 ||
        bytes != sizeof header + 4 * header.values + header.inside) {
        return wrong("has " + std::to_string(bytes) + " bytes, its header says otherwise", "an undamaged part");
    }
    SavedFieldPart saved;
    FieldPart& part = saved.part;
    part.values.resize(header.values);
    part.inside.resize(header.inside);
    if (!read_all(file, part.values, part.inside)) {
        return wrong("ends early", "an undamaged part");
    }
    if (checksum_of(header, data_of(part)) != header.checksum) {
        return wrong("checksum does not match", "an undamaged part");
    }
    part.kind = kind;
    part.input_hash = header.input_hash;
    part.settings_hash = header.settings_hash;
    part.first = header.first;
    part.count = header.count;
    part.rays = header.rays;
    part.dark_points = header.dark_points;
    part.cpu_s = header.cpu_s;
    if (kind == TransferKind::glossy) {
        GlossySettings& s = saved.glossy;
        s.transport = static_cast<Transport>(header.transport);
        s.order = header.order;
        s.out_order = header.out_order;
        s.max_bounces = header.max_bounces;
        s.rays = header.rays_setting;
        s.gather_rays = header.gather_rays;
        s.stop_energy = header.stop_energy;
        s.seed = header.seed;
        s.default_albedo = header.albedo;
        s.specular = header.specular;
        s.phong_exponent = header.phong_exponent;
    } else if (kind == TransferKind::neighbourhood) {
        NeighbourhoodSettings& s = saved.neighbourhood;
        s.order = header.order;
        s.out_order = header.out_order;
        s.rays = header.rays_setting;
        s.seed = header.seed;
        s.default_albedo = header.albedo;
        s.bounce = header.bounce != 0;
        saved.grid = {header.grid_size, header.grid_origin_m, header.grid_step_m};
    } else {
        VolumeSettings& s = saved.volume;
        s.order = header.order;
        s.max_bounces = header.max_bounces;
        s.directions = header.rays_setting;
        s.stop_energy = header.stop_energy;
        s.albedo = header.albedo;
    }
    return saved;
}

char part_file_kind(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::array<char, 8> start{};
    if (!file.read(start.data(), start.size())) {
        return 0;
    }
    return start == magic ? 'd' : start == field_magic ? 'f' : '\0';
}

} // namespace alpenglow::prt
