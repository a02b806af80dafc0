#include <alpenglow/prt/transfer_file.hpp>

#include <alpenglow/prt/hash.hpp>

#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace alpenglow::prt {
namespace {

static_assert(std::endian::native == std::endian::little, "transfer files are mapped as they stand");

constexpr std::array<char, 8> magic{'A', 'G', 'T', 'R', 'A', 'N', 'S', 'F'};
constexpr std::size_t section_count = 4;

struct Section {
    std::uint64_t offset = 0; // from the start of the file, a multiple of 64
    std::uint64_t bytes = 0;
};

struct FileHeader {
    std::array<char, 8> magic_value = magic;
    std::uint32_t version = transfer_file_version;
    std::uint32_t header_bytes = 0;
    std::uint64_t file_bytes = 0;
    std::uint64_t checksum = 0;                    // XXH3-64 of the file with this field zero
    std::array<Section, section_count> sections{}; // blocks, clusters, cluster_blocks, slot_points
    TransferInfo info;
};
static_assert(sizeof(TransferInfo) == 224 && sizeof(FileHeader) == 320);
static_assert(std::is_trivially_copyable_v<FileHeader>);

std::uint64_t aligned(std::uint64_t offset) {
    return (offset + 63) / 64 * 64;
}

std::uint64_t checksum(FileHeader header, std::span<const std::byte> rest) {
    header.checksum = 0;
    Hasher hasher;
    hasher.add(std::as_bytes(std::span(&header, 1)));
    hasher.add(rest);
    return hasher.digest();
}

Error system_error(const std::string& what, const std::filesystem::path& path) {
    return Error{what + ": " + std::strerror(errno), path.string(), ""};
}

// A mapped file; unmapped with the last table that uses it.
struct Mapping {
    void* address = MAP_FAILED;
    std::size_t bytes = 0;
    Mapping() = default;
    Mapping(const Mapping&) = delete;
    Mapping& operator=(const Mapping&) = delete;
    ~Mapping() {
        if (address != MAP_FAILED) {
            munmap(address, bytes);
        }
    }
};

} // namespace

Status write_file_atomically(const std::filesystem::path& path, std::span<const std::span<const std::byte>> parts) {
    const std::string temporary = path.string() + ".part-" + std::to_string(getpid());
    const int file = open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (file < 0) {
        return system_error("cannot create " + temporary, path);
    }
    bool good = true;
    for (std::span<const std::byte> part : parts) {
        while (good && !part.empty()) {
            const ssize_t written = write(file, part.data(), part.size());
            if (written < 0 && errno == EINTR) {
                continue;
            }
            good = written > 0;
            part = part.subspan(good ? static_cast<std::size_t>(written) : 0);
        }
    }
    good = good && fsync(file) == 0;
    int failure = errno;
    if (close(file) != 0 && good) {
        good = false;
        failure = errno;
    }
    if (good && std::rename(temporary.c_str(), path.c_str()) != 0) {
        good = false;
        failure = errno;
    }
    if (!good) {
        unlink(temporary.c_str());
        errno = failure;
        return system_error("cannot write", path);
    }
    return Ok{};
}

Status save_transfer(const TransferTable& table, const std::filesystem::path& path) {
    FileHeader header;
    header.header_bytes = sizeof(FileHeader);
    header.info = table.info;
    const std::array<std::span<const std::byte>, section_count> data{table.blocks, std::as_bytes(table.clusters),
                                                                     std::as_bytes(table.cluster_blocks),
                                                                     std::as_bytes(table.slot_points)};
    static constexpr std::array<std::byte, 64> zeros{};
    std::vector<std::span<const std::byte>> parts{{}};
    std::uint64_t offset = sizeof(FileHeader);
    for (std::size_t i = 0; i < section_count; ++i) {
        header.sections[i] = {aligned(offset), data[i].size()};
        parts.push_back(std::span(zeros).first(header.sections[i].offset - offset));
        parts.push_back(data[i]);
        offset = header.sections[i].offset + data[i].size();
    }
    header.file_bytes = offset;
    Hasher hasher;
    hasher.add(std::as_bytes(std::span(&header, 1)));
    for (const std::span<const std::byte> part : parts) {
        hasher.add(part);
    }
    header.checksum = hasher.digest();
    parts.front() = std::as_bytes(std::span(&header, 1));
    return write_file_atomically(path, parts);
}

Result<TransferTable> load_transfer(const std::filesystem::path& path, const LoadOptions& options) {
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) {
        return system_error("cannot open", path);
    }
    struct stat status {};
    if (fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) {
        close(file);
        return Error{"is not a regular file", path.string(), "a transfer file"};
    }
    const auto bytes = static_cast<std::size_t>(status.st_size);
    if (bytes < sizeof(FileHeader)) {
        close(file);
        return Error{"has " + std::to_string(bytes) + " bytes", path.string(),
                     "a transfer file, " + std::to_string(sizeof(FileHeader)) + " bytes or more"};
    }
    const auto mapping = std::make_shared<Mapping>();
    mapping->bytes = bytes;
    mapping->address = mmap(nullptr, bytes, PROT_READ, MAP_PRIVATE, file, 0);
    close(file);
    if (mapping->address == MAP_FAILED) {
        return system_error("cannot map", path);
    }
    const auto* start = static_cast<const std::byte*>(mapping->address);
    FileHeader header;
    std::memcpy(&header, start, sizeof(FileHeader));
    const auto wrong = [&](const std::string& what, const std::string& expected) {
        return Error{what, path.string(), expected};
    };
    if (header.magic_value != magic) {
        return wrong("is not a transfer file", "the mark AGTRANSF at its start");
    }
    if (header.version != transfer_file_version) {
        return wrong("version is " + std::to_string(header.version), std::to_string(transfer_file_version));
    }
    if (header.header_bytes != sizeof(FileHeader) || header.file_bytes != bytes) {
        return wrong("has " + std::to_string(bytes) + " bytes, its header says " + std::to_string(header.file_bytes),
                     "an untruncated file");
    }
    if (options.verify_checksum &&
        checksum(header, std::span(start + sizeof(FileHeader), bytes - sizeof(FileHeader))) != header.checksum) {
        return wrong("checksum does not match", "an undamaged file");
    }
    const TransferInfo& info = header.info;
    constexpr std::uint64_t most = std::uint64_t{1} << 40U; // keeps every product below within 64 bits
    const std::uint64_t root = static_cast<std::uint64_t>(std::lround(std::sqrt(static_cast<double>(info.rows))));
    const bool sane = info.kind <= TransferKind::neighbourhood && info.encoding <= Encoding::cpca && info.order >= 1 &&
                      info.order <= 6 && info.rows >= 1 && info.rows <= 36 && root * root == info.rows &&
                      (info.channels == 1 || info.channels == 3) && info.count <= most && info.slots <= 2 * most &&
                      info.slots >= info.count && info.slots % block_points == 0 && info.clusters <= 65536 &&
                      info.components <= 255;
    if (!sane) {
        return wrong("header is inconsistent", "order 1 .. 6, rows a square up to 36, 1 or 3 channels");
    }
    const bool cpca = info.encoding == Encoding::cpca;
    const std::uint64_t value_bytes = info.encoding == Encoding::f32 ? 4 : info.encoding == Encoding::f16 ? 2 : 1;
    const std::uint64_t width = info.width();
    const std::array<std::uint64_t, section_count> expected{
        cpca ? info.slots * info.components : info.slots * width * value_bytes,
        cpca ? info.clusters * (info.components + 1ULL) * width * 4 : 0, cpca ? (info.clusters + 1ULL) * 4 : 0,
        cpca ? info.slots * 4 : 0};
    for (std::size_t i = 0; i < section_count; ++i) {
        const Section& section = header.sections[i];
        if (section.bytes != expected[i] || section.offset % 64 != 0 || section.offset > bytes ||
            section.bytes > bytes - section.offset) {
            return wrong("section " + std::to_string(i) + " has " + std::to_string(section.bytes) + " bytes at " +
                             std::to_string(section.offset),
                         std::to_string(expected[i]) + " bytes within the file");
        }
    }
    if (options.expect_mesh_hash != 0 && info.mesh_hash != options.expect_mesh_hash) {
        return wrong("was baked for the mesh with hash " + std::to_string(info.mesh_hash),
                     "the mesh with hash " + std::to_string(options.expect_mesh_hash));
    }
    TransferTable table;
    table.info = info;
    table.owner = mapping;
    const auto section = [&](std::size_t i) { return start + header.sections[i].offset; };
    table.blocks = {section(0), header.sections[0].bytes};
    table.clusters = {reinterpret_cast<const float*>(section(1)), header.sections[1].bytes / 4};
    table.cluster_blocks = {reinterpret_cast<const std::uint32_t*>(section(2)), header.sections[2].bytes / 4};
    table.slot_points = {reinterpret_cast<const std::uint32_t*>(section(3)), header.sections[3].bytes / 4};
    if (cpca) {
        // Indices that the evaluation follows without looking.
        bool good = table.cluster_blocks.front() == 0 && table.cluster_blocks.back() == info.slots / block_points;
        for (std::size_t i = 0; good && i + 1 < table.cluster_blocks.size(); ++i) {
            good = table.cluster_blocks[i] <= table.cluster_blocks[i + 1];
        }
        for (const std::uint32_t point : table.slot_points) {
            good = good && (point < info.count || point == TransferTable::no_point);
        }
        if (!good) {
            return wrong("cluster tables point outside the file", "an undamaged file");
        }
    }
    return table;
}

} // namespace alpenglow::prt
