#include <alpenglow/prt/transfer_table.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <new>
#include <string>

#include <glm/gtc/packing.hpp>

namespace alpenglow::prt {
namespace {

int band_of(std::size_t coefficient) {
    int l = 0;
    while (static_cast<std::size_t>((l + 1) * (l + 1)) <= coefficient) {
        ++l;
    }
    return l;
}

} // namespace

std::shared_ptr<std::span<std::byte>> aligned_memory(std::size_t bytes) {
    struct Owner {
        std::span<std::byte> bytes;
        Owner() = default;
        Owner(const Owner&) = delete;
        Owner& operator=(const Owner&) = delete;
        ~Owner() { ::operator delete(bytes.data(), std::align_val_t(64)); }
    };
    const auto owner = std::make_shared<Owner>();
    const std::size_t size = std::max<std::size_t>(bytes, 1);
    owner->bytes = {static_cast<std::byte*>(::operator new(size, std::align_val_t(64))), bytes};
    std::memset(owner->bytes.data(), 0, size);
    return {owner, &owner->bytes};
}

void fill_band_norms(const TransferField& field, TransferInfo& info) {
    info.band_norm.fill(0.0F);
    const std::size_t n = static_cast<std::size_t>(field.coefficients());
    const auto channels = static_cast<std::size_t>(field.channels);
    const auto rows = static_cast<std::size_t>(field.rows());
    for (std::size_t p = 0; p < field.count; ++p) {
        const std::span<const float> values = field.point(p);
        for (std::size_t channel = 0; channel < channels; ++channel) {
            for (int l = 0; l < field.order; ++l) {
                double sum = 0.0;
                for (std::size_t row = 0; row < rows; ++row) {
                    const float* m = values.data() + (row * channels + channel) * n;
                    for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
                        sum += static_cast<double>(m[i]) * static_cast<double>(m[i]);
                    }
                }
                float& norm = info.band_norm[static_cast<std::size_t>(l)];
                norm = std::max(norm, static_cast<float>(std::sqrt(sum) * (1.0 + 1e-6)));
            }
        }
    }
}

double relative_rms(const TransferField& decoded, const TransferField& baked) {
    assert(decoded.values.size() == baked.values.size());
    double error = 0.0;
    double norm = 0.0;
    for (std::size_t i = 0; i < baked.values.size(); ++i) {
        const double b = static_cast<double>(baked.values[i]);
        const double d = static_cast<double>(decoded.values[i]) - b;
        error += d * d;
        norm += b * b;
    }
    return norm > 0.0 ? std::sqrt(error / norm) : 0.0;
}

Result<TransferTable> encode(const TransferField& field, Encoding encoding) {
    assert(encoding != Encoding::cpca);
    assert(field.values.size() == field.count * field.width());
    for (std::size_t i = 0; i < field.values.size(); ++i) {
        if (!std::isfinite(field.values[i])) {
            return Error{"value " + std::to_string(field.values[i]) + " at point " + std::to_string(i / field.width()),
                         "transfer field", "finite values"};
        }
    }
    TransferTable table;
    TransferInfo& info = table.info;
    info.kind = field.kind;
    info.encoding = encoding;
    info.order = static_cast<std::uint32_t>(field.order);
    info.rows = static_cast<std::uint32_t>(field.rows());
    info.channels = static_cast<std::uint32_t>(field.channels);
    info.count = field.count;
    info.slots = (field.count + block_points - 1) / block_points * block_points;
    info.mesh_hash = field.mesh_hash;
    info.grid_size = field.grid.size;
    info.grid_origin_m = field.grid.origin_m;
    info.grid_step_m = field.grid.step_m;
    fill_band_norms(field, info);

    const std::size_t width = field.width();
    const std::size_t n = info.coefficients();
    // The scale of each value in a point's row of `width` values.
    std::vector<float> scale(width, 1.0F);
    if (encoding == Encoding::s8) {
        std::array<float, 24> largest{};
        const auto place = [&](std::size_t k) {
            return (k / n % info.channels) * 8 + static_cast<std::size_t>(band_of(k % n));
        };
        for (std::size_t p = 0; p < field.count; ++p) {
            const std::span<const float> values = field.point(p);
            for (std::size_t k = 0; k < width; ++k) {
                float& top = largest[place(k)];
                top = std::max(top, std::abs(values[k]));
            }
        }
        for (std::size_t k = 0; k < width; ++k) {
            info.band_scale[place(k)] = largest[place(k)] / 127.0F;
            scale[k] = info.band_scale[place(k)];
        }
    }

    const std::size_t value_bytes = encoding == Encoding::f32 ? 4 : encoding == Encoding::f16 ? 2 : 1;
    const std::shared_ptr<std::span<std::byte>> memory = aligned_memory(info.slots * width * value_bytes);
    double error = 0.0;
    double norm = 0.0;
    for (std::size_t p = 0; p < field.count; ++p) {
        const std::span<const float> values = field.point(p);
        for (std::size_t k = 0; k < width; ++k) {
            const std::size_t at = ((p / block_points) * width + k) * block_points + p % block_points;
            std::byte* place = memory->data() + at * value_bytes;
            float stored = values[k];
            if (encoding == Encoding::f32) {
                std::memcpy(place, &stored, 4);
            } else if (encoding == Encoding::f16) {
                const std::uint16_t half = glm::packHalf1x16(std::clamp(values[k], -65504.0F, 65504.0F));
                std::memcpy(place, &half, 2);
                stored = glm::unpackHalf1x16(half);
            } else {
                const float steps = scale[k] > 0.0F ? values[k] / scale[k] : 0.0F;
                const auto integer = static_cast<std::int8_t>(std::lround(std::clamp(steps, -127.0F, 127.0F)));
                std::memcpy(place, &integer, 1);
                stored = static_cast<float>(integer) * scale[k];
            }
            const double d = static_cast<double>(stored) - static_cast<double>(values[k]);
            error += d * d;
            norm += static_cast<double>(values[k]) * static_cast<double>(values[k]);
        }
    }
    info.encoding_rms = norm > 0.0 ? static_cast<float>(std::sqrt(error / norm)) : 0.0F;
    table.blocks = *memory;
    table.owner = memory;
    return table;
}

TransferField decode(const TransferTable& table) {
    const TransferInfo& info = table.info;
    TransferField field;
    field.kind = info.kind;
    field.order = static_cast<int>(info.order);
    field.out_order = info.rows == 1 ? 0 : static_cast<int>(std::lround(std::sqrt(static_cast<double>(info.rows))));
    field.channels = static_cast<int>(info.channels);
    field.count = info.count;
    field.grid = {info.grid_size, info.grid_origin_m, info.grid_step_m};
    field.mesh_hash = info.mesh_hash;
    const std::size_t width = info.width();
    const std::size_t n = info.coefficients();
    field.values.resize(info.count * width);
    if (info.encoding == Encoding::cpca) {
        const std::size_t vectors = 1 + std::size_t{info.components};
        for (std::size_t cluster = 0; cluster < info.clusters; ++cluster) {
            const float* basis = table.clusters.data() + cluster * vectors * width;
            for (std::size_t slot = table.cluster_blocks[cluster] * block_points;
                 slot < table.cluster_blocks[cluster + 1] * block_points; ++slot) {
                if (table.slot_points[slot] == TransferTable::no_point) {
                    continue;
                }
                const std::span<float> values = field.point(table.slot_points[slot]);
                std::copy(basis, basis + width, values.begin());
                for (std::size_t j = 0; j < info.components; ++j) {
                    std::int8_t weight = 0;
                    std::memcpy(&weight,
                                table.blocks.data() + (slot / block_points * info.components + j) * block_points +
                                    slot % block_points,
                                1);
                    for (std::size_t k = 0; k < width; ++k) {
                        values[k] += static_cast<float>(weight) * basis[(j + 1) * width + k];
                    }
                }
            }
        }
        return field;
    }
    for (std::size_t p = 0; p < info.count; ++p) {
        const std::span<float> values = field.point(p);
        for (std::size_t k = 0; k < width; ++k) {
            const std::size_t at = ((p / block_points) * width + k) * block_points + p % block_points;
            if (info.encoding == Encoding::f32) {
                std::memcpy(&values[k], table.blocks.data() + at * 4, 4);
            } else if (info.encoding == Encoding::f16) {
                std::uint16_t half = 0;
                std::memcpy(&half, table.blocks.data() + at * 2, 2);
                values[k] = glm::unpackHalf1x16(half);
            } else {
                std::int8_t integer = 0;
                std::memcpy(&integer, table.blocks.data() + at, 1);
                values[k] = static_cast<float>(integer) *
                            info.band_scale[(k / n % info.channels) * 8 + static_cast<std::size_t>(band_of(k % n))];
            }
        }
    }
    return field;
}

} // namespace alpenglow::prt
