#include "landscape_file.hpp"

#include "terrain_mesh.hpp"

#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace alpenglow::sandbox {
namespace {

static_assert(std::endian::native == std::endian::little, "the file is mapped onto memory as it is");

constexpr std::size_t grid_count = static_cast<std::size_t>(Terrain::samples) * Terrain::samples;
constexpr std::size_t count = 2 * grid_count;
constexpr std::size_t chunk = 1U << 14U;
constexpr std::array<char, 8> magic{'A', 'G', 'L', 'A', 'N', 'D', 'S', 'C'};

struct Header {
    std::array<char, 8> magic = sandbox::magic;
    std::uint32_t version = landscape_version;
    std::uint32_t samples = Terrain::samples;
    std::uint32_t ratio = Terrain::ratio;
    float spacing_m = Terrain::inner_spacing_m;
    std::uint32_t seed = 0;
    std::uint32_t zero = 0;
    std::uint64_t zeros = 0;
    std::uint64_t bytes = count * (4 + 4 + 16 + 2 + 2);
    std::uint64_t checksum = 0;
    std::uint64_t header_checksum = 0;
};
static_assert(sizeof(Header) == 64);

std::uint64_t checksum_of(const Header& header) {
    return XXH3_64bits(&header, offsetof(Header, header_checksum));
}

class Writer {
public:
    explicit Writer(const std::filesystem::path& path) : file_(path, std::ios::binary) { XXH3_64bits_reset(&state_); }

    template <class T>
    void add(std::span<const T> values) {
        XXH3_64bits_update(&state_, values.data(), values.size_bytes());
        file_.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size_bytes()));
    }
    // One member of each vertex.
    template <class T>
    void add(std::span<const Vertex> vertices, T Vertex::*member) {
        std::vector<T> values(chunk);
        for (std::size_t k = 0; k < vertices.size(); k += chunk) {
            const std::size_t n = std::min(chunk, vertices.size() - k);
            for (std::size_t i = 0; i < n; ++i) {
                values[i] = vertices[k + i].*member;
            }
            add(std::span<const T>(values.data(), n));
        }
    }
    void put_header(const Header& header) {
        file_.seekp(0);
        file_.write(reinterpret_cast<const char*>(&header), sizeof header);
    }
    [[nodiscard]] std::uint64_t checksum() const { return XXH3_64bits_digest(&state_); }
    [[nodiscard]] bool close() {
        file_.close();
        return !file_.fail();
    }

private:
    std::ofstream file_;
    XXH3_state_t state_{};
};

class Reader {
public:
    explicit Reader(std::ifstream& file) : file_(file) { XXH3_64bits_reset(&state_); }

    template <class T>
    void get(std::span<T> values) {
        file_.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(values.size_bytes()));
        XXH3_64bits_update(&state_, values.data(), values.size_bytes());
    }
    template <class T>
    void get(std::span<Vertex> vertices, T Vertex::*member) {
        std::vector<T> values(chunk);
        for (std::size_t k = 0; k < vertices.size(); k += chunk) {
            const std::size_t n = std::min(chunk, vertices.size() - k);
            get(std::span<T>(values.data(), n));
            for (std::size_t i = 0; i < n; ++i) {
                vertices[k + i].*member = values[i];
            }
        }
    }
    [[nodiscard]] std::uint64_t checksum() const { return XXH3_64bits_digest(&state_); }

private:
    std::ifstream& file_;
    XXH3_state_t state_{};
};

Error wrong(const std::filesystem::path& path, const std::string& field, const std::string& value,
            const std::string& expected) {
    return {"is " + value, path.string() + ": " + field, expected};
}

// Nothing if the header fits this program.
Status check(const Header& header, const std::filesystem::path& path, std::uint64_t file_bytes, std::uint32_t seed) {
    if (header.magic != magic) {
        return wrong(path, "magic", "not a landscape's", "\"AGLANDSC\"");
    }
    if (header.version != landscape_version) {
        return wrong(path, "version", std::to_string(header.version), std::to_string(landscape_version));
    }
    if (header.header_checksum != checksum_of(header)) {
        return wrong(path, "header checksum", "not that of the header", "an undamaged file");
    }
    if (header.samples != Terrain::samples || header.ratio != Terrain::ratio ||
        header.spacing_m != Terrain::inner_spacing_m) {
        return wrong(path, "grid",
                     std::to_string(header.samples) + " samples, ratio " + std::to_string(header.ratio) + ", " +
                         std::to_string(header.spacing_m) + " m",
                     std::to_string(Terrain::samples) + " samples, ratio " + std::to_string(Terrain::ratio) + ", " +
                         std::to_string(Terrain::inner_spacing_m) + " m");
    }
    if (header.seed != seed) {
        return wrong(path, "seed", std::to_string(header.seed), std::to_string(seed));
    }
    const Header right;
    if (header.bytes != right.bytes || file_bytes != sizeof header + right.bytes) {
        return wrong(path, "size", std::to_string(file_bytes) + " bytes",
                     std::to_string(sizeof header + right.bytes) + " bytes");
    }
    return Ok{};
}

} // namespace

Status write_landscape(const World& world, const std::filesystem::path& path) {
    std::filesystem::path beside = path;
    beside += ".new";
    Writer file(beside);
    Header header;
    header.seed = world.terrain.seed;
    file.put_header(header);
    file.add(std::span<const float>(world.terrain.outer.height_m));
    file.add(std::span<const float>(world.terrain.inner.height_m));
    const std::span<const Vertex> vertices(world.data.terrain.vertices);
    file.add(vertices, &Vertex::albedo);
    file.add(vertices, &Vertex::horizon);
    file.add(std::span<const UpperBound>(world.lod->bounds().error_m));
    file.add(std::span<const UpperBound>(world.lod->bounds().radius_m));
    header.checksum = file.checksum();
    header.header_checksum = checksum_of(header);
    file.put_header(header);
    std::error_code failed;
    if (!file.close()) {
        std::filesystem::remove(beside, failed);
        return Error{"cannot be written", beside.string(), "a writable folder with room for 60 MB"};
    }
    std::filesystem::rename(beside, path, failed);
    if (failed) {
        return Error{"cannot be replaced: " + failed.message(), path.string(), "a file that may be replaced"};
    }
    return Ok{};
}

Result<std::unique_ptr<World>> read_landscape(const std::filesystem::path& path, std::uint32_t seed) {
    std::ifstream file(path, std::ios::binary);
    std::error_code failed;
    const std::uint64_t file_bytes = std::filesystem::file_size(path, failed);
    if (!file || failed) {
        return Error{"cannot be read", path.string(), "a landscape file"};
    }
    Header header;
    if (!file.read(reinterpret_cast<char*>(&header), sizeof header)) {
        return wrong(path, "size", std::to_string(file_bytes) + " bytes", "at least 64 bytes");
    }
    if (const Status fits = check(header, path, file_bytes, seed); !fits) {
        return fits.error();
    }
    auto world = std::make_unique<World>();
    world->terrain.seed = seed;
    Reader reader(file);
    for (const auto& [grid, spacing_m] : {std::pair{&world->terrain.outer, Terrain::outer_spacing_m},
                                          std::pair{&world->terrain.inner, Terrain::inner_spacing_m}}) {
        *grid = make_grid(Terrain::samples, spacing_m);
        reader.get(std::span(grid->height_m));
    }
    std::vector<Vertex>& vertices = world->data.terrain.vertices;
    vertices.resize(count);
    reader.get(std::span(vertices), &Vertex::albedo);
    reader.get(std::span(vertices), &Vertex::horizon);
    LodBounds bounds;
    bounds.error_m.resize(count);
    bounds.radius_m.resize(count);
    reader.get(std::span(bounds.error_m));
    reader.get(std::span(bounds.radius_m));
    if (!file || reader.checksum() != header.checksum) {
        return wrong(path, "checksum", "not that of the file's content", "an undamaged file");
    }
    shape_terrain_mesh(world->terrain, vertices);
    world->lod = std::make_unique<TerrainLod>(world->terrain, std::move(bounds));
    furnish(*world);
    return world;
}

std::filesystem::path built_landscape() {
#ifdef ALPENGLOW_LANDSCAPE
    return ALPENGLOW_LANDSCAPE;
#else
    return {};
#endif
}

OpenedWorld open_world(std::span<const std::filesystem::path> files, std::uint32_t seed) {
    OpenedWorld opened;
    for (const std::filesystem::path& path : files) {
        Result<std::unique_ptr<World>> world = read_landscape(path, seed);
        if (world) {
            opened.world = std::move(world).value();
            return opened;
        }
        opened.problems.push_back(world.error());
    }
    opened.world = build_world(seed);
    opened.generated = true;
    return opened;
}

} // namespace alpenglow::sandbox
