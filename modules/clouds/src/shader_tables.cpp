#include <alpenglow/clouds/shader_tables.hpp>

#include <algorithm>
#include <bit>
#include <cstring>

namespace alpenglow::clouds {
namespace {

std::uint32_t word(float value) {
    return std::bit_cast<std::uint32_t>(value);
}

void append_bytes(std::vector<std::uint32_t>& words, const void* data, std::size_t bytes) {
    const std::size_t at = words.size();
    words.resize(at + (bytes + 3) / 4, 0);
    std::memcpy(words.data() + at, data, bytes);
}

} // namespace

std::vector<std::uint32_t> pack_volume(const BrickVolume& volume) {
    constexpr std::size_t header = 16;
    std::vector<std::uint32_t> words(header, 0);
    const BrickTable& table = volume.table();
    words[0] = static_cast<std::uint32_t>(words.size());
    append_bytes(words, table.node_table().data(), table.node_table().size() * 4);
    words[1] = static_cast<std::uint32_t>(words.size());
    append_bytes(words, table.entries().data(), table.entries().size() * 4);
    words[2] = static_cast<std::uint32_t>(words.size());
    for (std::size_t b = 0; b < volume.scales().size(); ++b) {
        words.push_back(word(volume.scales()[b]));
        words.push_back(word(volume.offsets()[b]));
    }
    words[3] = static_cast<std::uint32_t>(words.size());
    static_assert(BrickVolume::brick_stride == 184 * 4, "cloud.glsl steps by 184 words a brick");
    append_bytes(words, volume.data().data(), volume.data().size());
    words[4] = static_cast<std::uint32_t>(table.nodes().x);
    words[5] = static_cast<std::uint32_t>(table.nodes().y);
    for (int a = 0; a < 3; ++a) {
        words[6 + std::size_t(a)] = static_cast<std::uint32_t>(volume.size()[a]);
        words[9 + std::size_t(a)] = word(static_cast<float>(volume.active_low()[a] - volume.min()[a] - 1));
        words[12 + std::size_t(a)] = word(static_cast<float>(volume.active_high()[a] - volume.min()[a] + 1));
    }
    return words;
}

namespace {

// Appends the values and writes the 16 words that describe them at `about`.
void describe(std::vector<std::uint32_t>& words, std::size_t about, const BrickVolume& volume, const Field16& field,
              const glm::vec3& direction, const glm::vec3& colour) {
    const Lattice& l = field.lattice;
    words[about] = static_cast<std::uint32_t>(words.size());
    for (int a = 0; a < 3; ++a) {
        words[about + 1 + std::size_t(a)] = static_cast<std::uint32_t>(l.dims[a]);
        words[about + 4 + std::size_t(a)] =
            word(static_cast<float>(l.first[a] - volume.min()[a]) + 0.5F * static_cast<float>(l.factor - 1));
        words[about + 10 + std::size_t(a)] = word(direction[a]);
        words[about + 13 + std::size_t(a)] = word(colour[a]);
    }
    words[about + 7] = word(1.0F / static_cast<float>(l.factor));
    words[about + 8] = word(field.offset);
    words[about + 9] = word(field.scale);
    append_bytes(words, field.values.data(), field.values.size() * 2);
}

} // namespace

std::vector<std::uint32_t> pack_light(const BrickVolume& volume, const CloudLighting& lighting) {
    const std::size_t lights = lighting.lights().size();
    std::vector<std::uint32_t> words(12 + 16 * lights, 0);
    words[0] = static_cast<std::uint32_t>(lights);
    words[3] = word(lighting.table().decay());
    words[4] = word(1.0F / lighting.table().max_depth());
    words[5] = word(lighting.table().narrow());
    words[6] = word(lighting.medium().extinction_per_m * lighting.eye_extinction());
    words[7] = word(1.0F / lighting.eye_extinction());
    words[2] = static_cast<std::uint32_t>(words.size());
    append_bytes(words, lighting.table().values().data(), lighting.table().values().size() * 4);
    for (std::size_t i = 0; i < lights; ++i) {
        const BakedLight& light = lighting.lights()[i];
        describe(words, 12 + 16 * i, volume, light.depth, light.to_light, light.irradiance);
    }
    return words;
}

std::vector<std::uint32_t> pack_view(const BrickVolume& volume, const CloudLighting& lighting,
                                     const CloudLighting::ViewFields& fields, const MarchSettings& settings) {
    const glm::dvec3 voxel = volume.transform().voxel_m;
    std::vector<std::uint32_t> words(16 + 16 * fields.fields.size(), 0);
    words[0] = static_cast<std::uint32_t>(fields.fields.size());
    words[1] = word(settings.step_voxels * static_cast<float>(std::min({voxel.x, voxel.y, voxel.z})));
    words[2] = word(settings.stop_transmittance);
    words[3] = lighting.settings().method == LightingMethod::harris ? 1U : 0U;
    words[4] = word(settings.optical_step);
    if (settings.detail != nullptr && settings.detail_strength > 0.0F) {
        words[5] = word(settings.detail_strength);
        words[6] = word(settings.detail_cells);
        words[7] = word(1.0F / volume.max_density());
        words[8] = settings.detail_offsets ? 1U : 0U;
        const DetailOffsets offsets = settings.detail_offsets.value_or(DetailOffsets{});
        for (int a = 0; a < 3; ++a) {
            words[9 + std::size_t(a)] = word(offsets.first[a]);
            words[12 + std::size_t(a)] = word(offsets.second[a]);
        }
    }
    for (std::size_t i = 0; i < fields.fields.size(); ++i) {
        const glm::vec3 channel(i == 0 ? 1.0F : 0.0F, i == 1 ? 1.0F : 0.0F, i == 2 ? 1.0F : 0.0F);
        describe(words, 16 + 16 * i, volume, fields.fields[i], glm::vec3(0.0F),
                 fields.fields.size() == 1 ? fields.colour : channel);
    }
    return words;
}

std::vector<std::uint32_t> pack_detail(const DetailTexture& texture) {
    std::vector<std::uint32_t> words;
    append_bytes(words, texture.data().data(), texture.data().size());
    return words;
}

glm::vec3 shader_eye(const BrickVolume& volume, const glm::dvec3& eye_m) {
    return glm::vec3(volume.transform().index_from_world(eye_m) - glm::dvec3(volume.min()));
}

} // namespace alpenglow::clouds
