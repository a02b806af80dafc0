#include <alpenglow/prt/shader_tables.hpp>

#include <algorithm>
#include <cassert>

namespace alpenglow::prt {

std::size_t shader_light(const TransferTable& table, std::span<const glm::vec3> light,
                         std::span<glm::vec3> out) noexcept {
    const TransferInfo& info = table.info;
    std::size_t used = 0;
    for (std::size_t l = 0; l < info.order && (l + 1) * (l + 1) <= light.size(); ++l) {
        for (std::size_t i = l * l; i < (l + 1) * (l + 1); ++i) {
            out[i] = light[i];
            if (info.encoding == Encoding::s8) {
                const std::size_t channel = info.channels == 3 ? 8 : 0;
                out[i] *= glm::vec3(info.band_scale[l], info.band_scale[channel + l], info.band_scale[2 * channel + l]);
            }
            used = i + 1;
        }
    }
    return used;
}

void light_clusters(const TransferTable& table, std::span<const glm::vec3> light, std::span<glm::vec3> out) noexcept {
    const TransferInfo& info = table.info;
    assert(info.encoding == Encoding::cpca && info.rows == 1);
    const std::size_t n = info.coefficients();
    const std::size_t used = std::min(n, light.size());
    const std::size_t vectors = info.clusters * (std::size_t{info.components} + 1);
    assert(out.size() >= vectors);
    const std::size_t channel = info.channels == 3 ? n : 0;
    for (std::size_t v = 0; v < vectors; ++v) {
        const float* m = table.clusters.data() + v * info.width();
        glm::vec3 sum(0.0F);
        for (std::size_t i = 0; i < used; ++i) {
            sum += glm::vec3(m[i], m[channel + i], m[2 * channel + i]) * light[i];
        }
        out[v] = sum;
    }
}

std::vector<glm::uvec2> vertex_slots(const TransferTable& table) {
    std::vector<glm::uvec2> slots(table.info.count, glm::uvec2(0));
    for (unsigned cluster = 0; cluster < table.info.clusters; ++cluster) {
        for (std::size_t slot = table.cluster_blocks[cluster] * block_points;
             slot < table.cluster_blocks[cluster + 1] * block_points; ++slot) {
            if (table.slot_points[slot] != TransferTable::no_point) {
                slots[table.slot_points[slot]] = {static_cast<unsigned>(slot), cluster};
            }
        }
    }
    return slots;
}

} // namespace alpenglow::prt
