#include <alpenglow/clouds/lighting.hpp>

#include "deposit.hpp"
#include "transport.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/parallel_for.hpp>
#include <alpenglow/core/timing.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <deque>
#include <numeric>

namespace alpenglow::clouds {
namespace {

std::size_t band_of(int k) {
    return std::size_t(k == 0 ? 0 : (k < 4 ? 1 : (k < 9 ? 2 : 3)));
}

float dot(const glm::vec3& a, const glm::vec3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Nodes whose trilinear interpolation has the cells' values as its means: less an eighth of second differences (what
// interpolation adds to the mean of a cell), along axes on which both neighbours are known. Not below 0.
std::vector<float> with_means(const Lattice& lattice, const std::vector<std::int32_t>& known,
                              const std::vector<float>& means) {
    std::vector<float> out(means);
    const std::size_t strides[3] = {1, std::size_t(lattice.dims.x),
                                    std::size_t(lattice.dims.x) * std::size_t(lattice.dims.y)};
    parallel_for(std::size_t(lattice.dims.z), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin * strides[2]; i < end * strides[2]; ++i) {
            if (known[i] < 0) {
                continue;
            }
            float bend = 0.0F;
            for (int a = 0; a < 3; ++a) {
                const auto length = static_cast<std::size_t>(lattice.dims[a]);
                const std::size_t c = i / strides[a] % length;
                if (c > 0 && c + 1 < length && known[i - strides[a]] >= 0 && known[i + strides[a]] >= 0) {
                    bend += means[i - strides[a]] - 2.0F * means[i] + means[i + strides[a]];
                }
            }
            out[i] = std::max(0.0F, means[i] - 0.125F * bend);
        }
    });
    return out;
}

} // namespace

// What is queued: a light's moments, or one channel of the sky's.
struct CloudLighting::Jobs {
    struct Item {
        bool sky;
        std::size_t index;
        TransportJob job;
    };
    std::deque<Item> queue;

    void drop(bool sky, std::size_t from_index, std::size_t to_index) {
        std::erase_if(queue, [&](const Item& item) {
            return item.sky == sky && item.index >= from_index && item.index < to_index;
        });
    }
};

CloudLighting::CloudLighting() : jobs_(std::make_unique<Jobs>()) {}
CloudLighting::~CloudLighting() = default;
CloudLighting::CloudLighting(CloudLighting&&) noexcept = default;
CloudLighting& CloudLighting::operator=(CloudLighting&&) noexcept = default;

void CloudLighting::reset(const BrickVolume& volume, const Medium& medium, const LightingSettings& settings) {
    volume_ = &volume;
    medium_ = medium;
    settings_ = settings;
    jobs_->queue.clear();
    lights_.clear();
    sky_.clear();
    std::array<double, 4> chi{};
    phase_moments(medium.phase, chi);
    switch (settings.method) {
    case LightingMethod::single_scattering:
        table_ = std::make_shared<BeamTable>(BeamTable::single_scattering(medium));
        break;
    case LightingMethod::harris: {
        Medium eye = medium;
        eye.phase = settings.harris_phase;
        phase_moments(eye.phase, chi);
        table_ = std::make_shared<BeamTable>(BeamTable::single_scattering(eye));
        break;
    }
    case LightingMethod::octaves:
        table_ = std::make_shared<BeamTable>(BeamTable::octaves(medium, settings.octaves));
        break;
    case LightingMethod::transport:
        table_ = std::make_shared<BeamTable>(BeamTable::broadened(medium));
        break;
    }
    const bool ours = settings.method == LightingMethod::transport;
    const ScaledMedium scaled = scaled_medium(medium);
    eye_extinction_ = ours ? static_cast<float>(scaled.extinction) : 1.0F;
    for (std::size_t l = 0; l < 4; ++l) {
        view_weights_[l] =
            static_cast<float>(ours ? scaled.albedo * scaled.moments[l] : double(medium.albedo) * chi[l]);
    }
    depth_lattice_ = lattice_over(volume, settings.depth_factor, 1, settings.max_depth_cells);
    depth_density_ = volume.block_means(depth_lattice_.first, depth_lattice_.dims, depth_lattice_.factor);
    const Lattice coarse = lattice_over(volume, settings.transport_factor, 1, settings.max_transport_cells);
    const glm::vec3 block = glm::vec3(volume.transform().voxel_m) * static_cast<float>(coarse.factor);
    transport_ = std::make_unique<Transport>(coarse, volume.block_means(coarse.first, coarse.dims, coarse.factor),
                                             block, medium);
}

BakeStats CloudLighting::bake_light(std::size_t i, const DirectionalLight& light, bool warm) {
    BakeStats stats = start_light(i, light, warm);
    const BakeStats rest = finish();
    stats.transport_s += rest.transport_s;
    stats.residual = rest.residual;
    return stats;
}

BakeStats CloudLighting::finish() {
    BakeStats stats;
    const double start = process_cpu_seconds();
    std::deque<Jobs::Item>& queue = jobs_->queue;
    // A job alone has two threads for its sweeps, and one for what lies between them; several have one each.
    if (queue.size() == 1) {
        queue.front().job.run();
    } else {
        parallel_for(queue.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                while (!queue[i].job.done()) {
                    queue[i].job.advance();
                }
            }
        });
    }
    for (const Jobs::Item& item : queue) {
        stats.residual = std::max(stats.residual, item.job.change());
        (item.sky ? sky_[item.index] : lights_[item.index].moments) = item.job.moments();
    }
    queue.clear();
    stats.transport_s = process_cpu_seconds() - start;
    return stats;
}

bool CloudLighting::working() const {
    return !jobs_->queue.empty();
}

bool CloudLighting::working_on_light(std::size_t i) const {
    return std::any_of(jobs_->queue.begin(), jobs_->queue.end(),
                       [i](const Jobs::Item& item) { return !item.sky && item.index == i; });
}

bool CloudLighting::working_on_sky() const {
    return std::any_of(jobs_->queue.begin(), jobs_->queue.end(), [](const Jobs::Item& item) { return item.sky; });
}

bool CloudLighting::advance() {
    if (jobs_->queue.empty()) {
        return false;
    }
    Jobs::Item& item = jobs_->queue.front();
    item.job.advance();
    if (item.job.done()) {
        (item.sky ? sky_[item.index] : lights_[item.index].moments) = item.job.moments();
        jobs_->queue.pop_front();
    }
    return true;
}

BakeStats CloudLighting::start_light(std::size_t i, const DirectionalLight& light, bool warm) {
    assert(volume_ != nullptr && i <= lights_.size());
    BakeStats stats;
    if (i == lights_.size()) {
        lights_.emplace_back();
    }
    BakedLight& baked = lights_[i];
    const glm::dvec3 local = volume_->transform().local_direction(glm::dvec3(light.to_light));
    baked.to_light = glm::vec3(local / std::sqrt(local.x * local.x + local.y * local.y + local.z * local.z));
    baked.irradiance = light.irradiance;
    if (volume_->empty()) {
        baked.depth = Field16(depth_lattice_, std::vector<float>(depth_lattice_.cells(), 0.0F));
        return stats;
    }
    const double start = process_cpu_seconds();
    const glm::vec3 voxel(volume_->transform().voxel_m);
    const glm::vec3 block = voxel * static_cast<float>(depth_lattice_.factor);
    if (settings_.method == LightingMethod::harris) {
        const float gain = medium_.albedo * phase_value(settings_.harris_phase, 0.0F);
        baked.depth = Field16(depth_lattice_, harris_depth(depth_lattice_, depth_density_, block, baked.to_light,
                                                           medium_.extinction_per_m, gain, settings_.harris_saturate));
        stats.depth_s = process_cpu_seconds() - start;
        return stats;
    }
    const float scaled_extinction = medium_.extinction_per_m * eye_extinction_;
    LightDepth depth = light_depth(depth_lattice_, depth_density_, block, baked.to_light, scaled_extinction);
    // Depths beyond the table's end hold no light: the field's 16 bits are for the rest.
    const auto field_of = [&](const std::vector<float>& depths) {
        std::vector<float> values = sharpened(depth_lattice_, depths);
        const float most = 4.0F * table_->max_depth();
        parallel_for(values.size(), 65536, [&](std::size_t begin, std::size_t end) {
            for (std::size_t c = begin; c < end; ++c) {
                values[c] = std::min(values[c] * medium_.extinction_per_m, most);
            }
        });
        return Field16(depth_lattice_, values);
    };
    if (settings_.method != LightingMethod::transport) {
        baked.depth = field_of(depth.depth);
        stats.depth_s = process_cpu_seconds() - start;
        return stats;
    }
    // What the beam loses in each coarse cell, from the fine lattice: extinction times the beam at voxel centres,
    // averaged along the light over the voxel, and the whole rescaled to what the columns say is lost. Without that 3
    // to 8 % of the sun's energy would go missing.
    const Lattice& coarse = transport_->lattice();
    std::vector<float> deposit(coarse.cells(), 0.0F);
    const float main = std::max({std::abs(baked.to_light.x / block.x), std::abs(baked.to_light.y / block.y),
                                 std::abs(baked.to_light.z / block.z)});
    const float thickness = 1.0F / main; // of a slab along the light
    const float fine_volume = block.x * block.y * block.z;
    const glm::vec3 coarse_block = voxel * static_cast<float>(coarse.factor);
    const float share = fine_volume / (coarse_block.x * coarse_block.y * coarse_block.z);
    std::vector<int> coarse_x(static_cast<std::size_t>(depth_lattice_.dims.x));
    const auto coarse_of = [&](int axis, int cell) {
        const float centre = static_cast<float>(depth_lattice_.first[axis] + cell * depth_lattice_.factor) +
                             0.5F * static_cast<float>(depth_lattice_.factor - 1);
        return std::clamp(static_cast<int>(std::floor((centre - static_cast<float>(coarse.first[axis]) + 0.5F) /
                                                      static_cast<float>(coarse.factor))),
                          0, coarse.dims[axis] - 1);
    };
    for (int x = 0; x < depth_lattice_.dims.x; ++x) {
        coarse_x[std::size_t(x)] = coarse_of(0, x);
    }
    // Fine slices by the coarse one that they lie in: threads own coarse slices.
    std::vector<int> begin_of(static_cast<std::size_t>(coarse.dims.z) + 1, depth_lattice_.dims.z);
    for (int z = depth_lattice_.dims.z - 1; z >= 0; --z) {
        begin_of[std::size_t(coarse_of(2, z))] = z;
    }
    for (std::size_t c = std::size_t(coarse.dims.z); c-- > 0;) {
        begin_of[c] = std::min(begin_of[c], begin_of[c + 1]);
    }
    std::vector<double> totals(static_cast<std::size_t>(coarse.dims.z), 0.0);
    parallel_for(std::size_t(coarse.dims.z), 2, [&](std::size_t begin, std::size_t end) {
        const auto width = static_cast<std::size_t>(depth_lattice_.dims.x);
        std::vector<float> line(width + 16); // deposit_row works in whole vectors
        std::vector<float> last_density(width + 16, 0.0F);
        std::vector<float> last_depth(width + 16, 0.0F);
        for (std::size_t slice = begin; slice < end; ++slice) {
            for (int z = begin_of[slice]; z < begin_of[slice + 1]; ++z) {
                for (int y = 0; y < depth_lattice_.dims.y; ++y) {
                    const std::size_t row = (std::size_t(z) * std::size_t(depth_lattice_.dims.y) + std::size_t(y)) *
                                            std::size_t(depth_lattice_.dims.x);
                    float* to = deposit.data() + (slice * std::size_t(coarse.dims.y) + std::size_t(coarse_of(1, y))) *
                                                     std::size_t(coarse.dims.x);
                    const float* density = depth_density_.data() + row;
                    const float* optical = depth.depth.data() + row;
                    if (row + width + 16 > depth_density_.size()) { // the lattice's last row has nothing after it
                        std::copy_n(density, width, last_density.begin());
                        std::copy_n(optical, width, last_depth.begin());
                        density = last_density.data();
                        optical = last_depth.data();
                    }
                    deposit_row(density, optical, scaled_extinction, thickness, line.data(), static_cast<int>(width));
                    float sum = 0.0F;
                    for (std::size_t x = 0; x < width; ++x) {
                        to[coarse_x[x]] += line[x];
                        sum += line[x];
                    }
                    totals[slice] += double(sum);
                }
            }
        }
    });
    const double total = std::accumulate(totals.begin(), totals.end(), 0.0);
    const auto rescale = static_cast<float>(total > 0.0 ? depth.removed_m2 / (total * double(fine_volume)) : 1.0);
    for (std::size_t c = 0; c < deposit.size(); ++c) {
        deposit[c] = transport_->extinction()[c] > 0.0F ? deposit[c] * share * rescale : 0.0F;
    }
    baked.depth = field_of(depth.depth);
    stats.depth_s = process_cpu_seconds() - start;
    if (!warm) {
        baked.moments.clear();
    }
    jobs_->drop(false, i, i + 1);
    TransportJob::Source source;
    source.deposit = std::move(deposit);
    source.to_light = baked.to_light;
    const int sweeps = baked.moments.empty() ? settings_.sweeps : settings_.warm_sweeps;
    jobs_->queue.push_back({false, i, TransportJob(*transport_, std::move(source), sweeps, baked.moments)});
    return stats;
}

void CloudLighting::remove_lights(std::size_t keep) {
    if (keep < lights_.size()) {
        jobs_->drop(false, keep, lights_.size());
        lights_.resize(keep);
    }
}

BakeStats CloudLighting::bake_sky(const SkySh& sky, bool warm) {
    const double start = process_cpu_seconds();
    start_sky(sky, warm);
    BakeStats stats = finish();
    stats.transport_s = process_cpu_seconds() - start;
    return stats;
}

void CloudLighting::start_sky(const SkySh& sky, bool warm) {
    assert(volume_ != nullptr);
    jobs_->drop(true, 0, 3);
    if (sky.bands == 0 || volume_->empty()) {
        sky_.clear();
        return;
    }
    if (settings_.method != LightingMethod::transport) {
        bake_sky_directly(sky);
        return;
    }
    // One solve does if all coefficients have one colour.
    const glm::vec3 colour = sky.coefficients[0];
    const float brightest = std::max({colour.x, colour.y, colour.z});
    bool one = brightest > 0.0F;
    for (int k = 1; one && k < sky.bands * sky.bands; ++k) {
        const glm::vec3& c = sky.coefficients[std::size_t(k)];
        const float scale = dot(c, colour) / dot(colour, colour);
        const glm::vec3 off = c - colour * scale;
        one = dot(off, off) <= 1e-6F * dot(colour, colour);
    }
    const std::size_t channels = one ? 1 : 3;
    if (!warm || sky_.size() != channels) {
        sky_.assign(channels, {});
    }
    sky_colour_ = one ? colour / brightest : glm::vec3(1.0F);
    const Ordinate* table = ordinate_table();
    for (std::size_t channel = 0; channel < channels; ++channel) {
        TransportJob::Source source;
        for (int i = 0; i < ordinates; ++i) {
            const glm::vec3 from(volume_->transform().axes * glm::dvec3(-table[i].direction));
            const glm::vec3 rgb = sky.radiance(from);
            const float value =
                one ? dot(rgb, colour) / dot(colour, colour) * brightest : rgb[static_cast<int>(channel)];
            source.inflow[std::size_t(i)] = std::max(value, 0.0F);
        }
        const int sweeps = sky_[channel].empty() ? settings_.sweeps : settings_.warm_sweeps;
        jobs_->queue.push_back({true, channel, TransportJob(*transport_, source, sweeps, sky_[channel])});
    }
}

// For the classic methods: skylight as many directional lights (course notes, 2.3.1), singly scattered, gathered as
// moments.
void CloudLighting::bake_sky_directly(const SkySh& sky) {
    const Lattice& coarse = transport_->lattice();
    const glm::vec3 block = glm::vec3(volume_->transform().voxel_m) * static_cast<float>(coarse.factor);
    const std::vector<float> density = volume_->block_means(coarse.first, coarse.dims, coarse.factor);
    sky_.assign(3, std::vector<float>(16 * transport_->active_count(), 0.0F));
    sky_colour_ = glm::vec3(1.0F);
    const int count = 24; // directions on a Fibonacci spiral
    for (int i = 0; i < count; ++i) {
        const double z = 1.0 - 2.0 * (i + 0.5) / count;
        const double azimuth = pi * (3.0 - std::sqrt(5.0)) * i;
        const double s = std::sqrt(1.0 - z * z);
        const glm::vec3 to(glm::dvec3(s * std::cos(azimuth), s * std::sin(azimuth), z));
        const glm::vec3 radiance =
            sky.radiance(glm::vec3(volume_->transform().axes * glm::dvec3(to))) * static_cast<float>(4.0 * pi / count);
        const LightDepth depth = light_depth(coarse, density, block, to, 1.0F);
        float y[16];
        sh_bands4(-to, y);
        for (std::size_t cell = 0; cell < density.size(); ++cell) {
            const std::int32_t a = transport_->active()[cell];
            if (a >= 0) {
                const float t = std::exp(-medium_.extinction_per_m * depth.depth[cell]);
                for (std::size_t c = 0; c < 3; ++c) {
                    float* m = sky_[c].data() + 16 * std::size_t(a);
                    for (std::size_t k = 0; k < 16; ++k) {
                        m[k] += radiance[static_cast<int>(c)] * t * y[k];
                    }
                }
            }
        }
    }
}

CloudLighting::ViewFields CloudLighting::contract(const glm::dvec3& eye) const {
    return contract(&eye);
}

CloudLighting::ViewFields CloudLighting::contract_mean() const {
    return contract(nullptr);
}

CloudLighting::ViewFields CloudLighting::contract(const glm::dvec3* eye) const {
    ViewFields out;
    if (volume_ == nullptr || transport_->active_count() == 0) {
        return out;
    }
    struct Term {
        const float* moments;
        glm::vec3 colour;
    };
    std::vector<Term> terms;
    for (const BakedLight& light : lights_) {
        if (!light.moments.empty()) {
            terms.push_back({light.moments.data(), light.irradiance});
        }
    }
    for (std::size_t c = 0; c < sky_.size(); ++c) {
        if (!sky_[c].empty()) {
            terms.push_back({sky_[c].data(), sky_.size() == 1 ? sky_colour_
                                                              : glm::vec3(c == 0 ? 1.0F : 0.0F, c == 1 ? 1.0F : 0.0F,
                                                                          c == 2 ? 1.0F : 0.0F)});
        }
    }
    if (terms.empty()) {
        return out;
    }
    const glm::vec3 first = terms[0].colour;
    const float strength = std::max({first.x, first.y, first.z, 1e-30F});
    out.colour = first / strength;
    bool one = true;
    for (const Term& term : terms) {
        const float scale = dot(term.colour, out.colour) / dot(out.colour, out.colour);
        const glm::vec3 off = term.colour - out.colour * scale;
        one = one && dot(off, off) <= 1e-6F * dot(term.colour, term.colour);
    }
    const std::size_t channels = one ? 1 : 3;
    if (!one) {
        out.colour = glm::vec3(1.0F);
    }
    const Lattice& lattice = transport_->lattice();
    std::vector<std::vector<float>> values(channels, std::vector<float>(lattice.cells(), 0.0F));
    const glm::vec3 voxel(volume_->transform().voxel_m);
    const auto plane = std::size_t(lattice.dims.x) * std::size_t(lattice.dims.y);
    float weights[16];
    for (int k = 0; k < 16; ++k) {
        weights[k] = eye != nullptr || k == 0 ? view_weights_[band_of(k)] : 0.0F;
    }
    parallel_for(std::size_t(lattice.dims.z), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t cell = begin * plane; cell < end * plane; ++cell) {
            const std::int32_t a = transport_->active()[cell];
            if (a < 0) {
                continue;
            }
            const glm::ivec3 c(static_cast<int>(cell % std::size_t(lattice.dims.x)),
                               static_cast<int>(cell / std::size_t(lattice.dims.x) % std::size_t(lattice.dims.y)),
                               static_cast<int>(cell / plane));
            const glm::vec3 at = glm::vec3(lattice.first) + glm::vec3(c * lattice.factor) +
                                 0.5F * static_cast<float>(lattice.factor - 1);
            glm::vec3 towards_eye = (eye != nullptr ? glm::vec3(*eye) - at : glm::vec3(0.0F)) * voxel;
            const float length2 = dot(towards_eye, towards_eye);
            towards_eye = length2 > 0.0F ? towards_eye / std::sqrt(length2) : glm::vec3(0.0F, 0.0F, 1.0F);
            float y[16];
            sh_bands4(towards_eye, y);
            for (int k = 0; k < 16; ++k) {
                y[k] *= weights[k];
            }
            glm::vec3 sum(0.0F);
            for (const Term& term : terms) {
                const float* m = term.moments + 16 * std::size_t(a);
                float s = 0.0F;
                for (int k = 0; k < 16; ++k) {
                    s += y[k] * m[k];
                }
                sum += term.colour * s;
            }
            if (one) {
                values[0][cell] = std::max(0.0F, dot(sum, out.colour) / dot(out.colour, out.colour));
            } else {
                for (std::size_t channel = 0; channel < 3; ++channel) {
                    values[channel][cell] = std::max(0.0F, sum[static_cast<int>(channel)]);
                }
            }
        }
    });
    for (const std::vector<float>& channel : values) {
        out.fields.emplace_back(lattice, with_means(lattice, transport_->active(), channel));
    }
    return out;
}

glm::vec3 CloudLighting::mean_radiance(const glm::vec3& index) const {
    if (volume_ == nullptr || transport_->active_count() == 0) {
        return glm::vec3(0.0F);
    }
    const Lattice& lattice = transport_->lattice();
    glm::ivec3 cell;
    for (int axis = 0; axis < 3; ++axis) {
        cell[axis] =
            std::clamp(static_cast<int>(std::floor((index[axis] - static_cast<float>(lattice.first[axis]) + 0.5F) /
                                                   static_cast<float>(lattice.factor))),
                       0, lattice.dims[axis] - 1);
    }
    const std::int32_t a =
        transport_->active()[(std::size_t(cell.z) * std::size_t(lattice.dims.y) + std::size_t(cell.y)) *
                                 std::size_t(lattice.dims.x) +
                             std::size_t(cell.x)];
    if (a < 0) {
        return glm::vec3(0.0F);
    }
    constexpr float mean = 0.28209479F; // m_0 / Y_0 / (4 pi) = m_0 Y_0
    glm::vec3 sum(0.0F);
    for (const BakedLight& light : lights_) {
        if (!light.moments.empty()) {
            sum += light.irradiance * (light.moments[16 * std::size_t(a)] * mean);
        }
    }
    for (std::size_t c = 0; c < sky_.size(); ++c) {
        const float value = sky_[c][16 * std::size_t(a)] * mean;
        if (sky_.size() == 1) {
            sum += sky_colour_ * value;
        } else {
            sum[static_cast<int>(c)] += value;
        }
    }
    return sum;
}

std::size_t CloudLighting::memory_bytes() const {
    std::size_t bytes = depth_density_.size() * sizeof(float) + (transport_ ? transport_->memory_bytes() : 0) +
                        table_->values().size() * sizeof(float);
    for (const BakedLight& light : lights_) {
        bytes += light.depth.memory_bytes() + light.moments.size() * sizeof(float);
    }
    for (const auto& sky : sky_) {
        bytes += sky.size() * sizeof(float);
    }
    return bytes;
}

} // namespace alpenglow::clouds
