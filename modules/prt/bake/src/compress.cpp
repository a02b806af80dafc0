#include <alpenglow/prt/compress.hpp>

#include <alpenglow/core/parallel_for.hpp>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>

namespace alpenglow::prt {
namespace {

constexpr std::size_t grain = 256;

struct Cluster {
    std::vector<float> mean;
    std::vector<float> basis; // [component][width], orthonormal
};

// Squared distance of a point to the cluster's affine subspace, and its weights.
float fit(const Cluster& cluster, std::span<const float> x, std::size_t components, float* scratch, float* weights) {
    const std::size_t width = x.size();
    float left = 0.0F;
    for (std::size_t k = 0; k < width; ++k) {
        scratch[k] = x[k] - cluster.mean[k];
        left += scratch[k] * scratch[k];
    }
    for (std::size_t j = 0; j < components; ++j) {
        const float* b = cluster.basis.data() + j * width;
        float w = 0.0F;
        for (std::size_t k = 0; k < width; ++k) {
            w += b[k] * scratch[k];
        }
        weights[j] = w;
        left -= w * w;
    }
    return left;
}

void refit(const TransferField& field, const std::vector<std::uint32_t>& members, std::size_t components,
           Cluster& cluster) {
    const std::size_t width = field.width();
    const auto n = static_cast<Eigen::Index>(width);
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(n);
    for (const std::uint32_t p : members) {
        const std::span<const float> x = field.point(p);
        for (std::size_t k = 0; k < width; ++k) {
            mean[static_cast<Eigen::Index>(k)] += static_cast<double>(x[k]);
        }
    }
    mean /= static_cast<double>(std::max<std::size_t>(members.size(), 1));
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd d(n);
    for (const std::uint32_t p : members) {
        const std::span<const float> x = field.point(p);
        for (std::size_t k = 0; k < width; ++k) {
            d[static_cast<Eigen::Index>(k)] = static_cast<double>(x[k]) - mean[static_cast<Eigen::Index>(k)];
        }
        covariance.selfadjointView<Eigen::Lower>().rankUpdate(d);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance);
    cluster.mean.resize(width);
    cluster.basis.assign(components * width, 0.0F);
    for (std::size_t k = 0; k < width; ++k) {
        cluster.mean[k] = static_cast<float>(mean[static_cast<Eigen::Index>(k)]);
        for (std::size_t j = 0; j < components; ++j) { // eigenvalues rise: the last are the largest
            cluster.basis[j * width + k] = static_cast<float>(
                solver.eigenvectors()(static_cast<Eigen::Index>(k), n - 1 - static_cast<Eigen::Index>(j)));
        }
    }
}

struct Clustering {
    std::vector<Cluster> clusters;
    std::vector<std::uint32_t> of_point;
    std::vector<std::vector<std::uint32_t>> members;
};

void assign(const TransferField& field, std::size_t components, unsigned threads, Clustering& clustering,
            std::vector<float>& error) {
    const std::size_t width = field.width();
    parallel_for(
        field.count, grain,
        [&](std::size_t begin, std::size_t end) {
            std::vector<float> scratch(width);
            std::vector<float> weights(std::max<std::size_t>(components, 1));
            for (std::size_t p = begin; p < end; ++p) {
                float best = std::numeric_limits<float>::max();
                for (std::size_t c = 0; c < clustering.clusters.size(); ++c) {
                    const float e =
                        fit(clustering.clusters[c], field.point(p), components, scratch.data(), weights.data());
                    if (e < best) {
                        best = e;
                        clustering.of_point[p] = static_cast<std::uint32_t>(c);
                    }
                }
                error[p] = best;
            }
        },
        threads);
    for (std::vector<std::uint32_t>& list : clustering.members) {
        list.clear();
    }
    for (std::size_t p = 0; p < field.count; ++p) {
        clustering.members[clustering.of_point[p]].push_back(static_cast<std::uint32_t>(p));
    }
}

Clustering cluster_points(const TransferField& field, const CpcaSettings& settings, std::size_t components) {
    const std::size_t k = std::min(settings.clusters, field.count);
    const std::size_t width = field.width();
    Clustering clustering;
    clustering.of_point.resize(field.count);
    clustering.members.resize(k);
    clustering.clusters.resize(k);
    // Evenly spaced points to start with: neighbours in a mesh's order are neighbours on it, mostly.
    for (std::size_t c = 0; c < k; ++c) {
        const std::span<const float> x = field.point((2 * c + 1) * field.count / (2 * k));
        clustering.clusters[c].mean.assign(x.begin(), x.end());
        clustering.clusters[c].basis.assign(components * width, 0.0F);
    }
    std::vector<float> error(field.count);
    for (int iteration = 0; iteration < settings.iterations; ++iteration) {
        // The first third clusters by the mean alone, then by the whole subspace (section 4 of the paper).
        const std::size_t used = iteration < settings.iterations / 3 ? 0 : components;
        assign(field, used, settings.threads, clustering, error);
        // An empty cluster starts again at the point that is represented worst.
        for (std::size_t c = 0; c < k; ++c) {
            if (clustering.members[c].empty()) {
                const auto worst = std::max_element(error.begin(), error.end()) - error.begin();
                error[static_cast<std::size_t>(worst)] = 0.0F;
                clustering.members[c].push_back(static_cast<std::uint32_t>(worst));
            }
        }
        parallel_for(
            k, 1,
            [&](std::size_t begin, std::size_t) {
                refit(field, clustering.members[begin], components, clustering.clusters[begin]);
            },
            settings.threads);
    }
    assign(field, components, settings.threads, clustering, error);
    return clustering;
}

struct Memory {
    std::shared_ptr<std::span<std::byte>> blocks;
    std::vector<float> clusters;
    std::vector<std::uint32_t> cluster_blocks;
    std::vector<std::uint32_t> slot_points;
};

} // namespace

Result<TransferTable> encode_cpca(const TransferField& field, const CpcaSettings& settings) {
    const std::size_t width = field.width();
    if (settings.clusters < 1 || settings.clusters > 65536 || settings.components < 1 || settings.components > 255) {
        return Error{std::to_string(settings.clusters) + " clusters, " + std::to_string(settings.components) +
                         " components",
                     "CPCA settings", "1 .. 65536 clusters, 1 .. 255 components"};
    }
    if (field.count == 0 || field.count >= TransferTable::no_point || width > 1024) {
        return Error{std::to_string(field.count) + " points of " + std::to_string(width) + " values", "CPCA",
                     "1 to 2^32 - 2 points of up to 1024 values"};
    }
    for (std::size_t i = 0; i < field.values.size(); ++i) {
        if (!std::isfinite(field.values[i])) {
            return Error{"value " + std::to_string(field.values[i]) + " at point " + std::to_string(i / width),
                         "transfer field", "finite values"};
        }
    }
    const std::size_t components = std::min(settings.components, width);
    const Clustering clustering = cluster_points(field, settings, components);

    const auto memory = std::make_shared<Memory>();
    memory->cluster_blocks.push_back(0);
    std::vector<std::size_t> kept; // clusters that have points
    for (std::size_t c = 0; c < clustering.clusters.size(); ++c) {
        if (clustering.members[c].empty()) {
            continue;
        }
        kept.push_back(c);
        for (const std::uint32_t p : clustering.members[c]) {
            memory->slot_points.push_back(p);
        }
        while (memory->slot_points.size() % block_points != 0) {
            memory->slot_points.push_back(TransferTable::no_point);
        }
        memory->cluster_blocks.push_back(static_cast<std::uint32_t>(memory->slot_points.size() / block_points));
    }
    memory->clusters.resize(kept.size() * (1 + components) * width);
    memory->blocks = aligned_memory(memory->slot_points.size() * components);
    parallel_for(
        kept.size(), 1,
        [&](std::size_t at, std::size_t) {
            const Cluster& cluster = clustering.clusters[kept[at]];
            const std::vector<std::uint32_t>& members = clustering.members[kept[at]];
            std::vector<float> scratch(width);
            std::vector<float> weights(members.size() * components);
            std::vector<float> largest(components, 0.0F);
            for (std::size_t m = 0; m < members.size(); ++m) {
                float* w = weights.data() + m * components;
                fit(cluster, field.point(members[m]), components, scratch.data(), w);
                for (std::size_t j = 0; j < components; ++j) {
                    largest[j] = std::max(largest[j], std::abs(w[j]));
                }
            }
            float* stored = memory->clusters.data() + at * (1 + components) * width;
            std::copy(cluster.mean.begin(), cluster.mean.end(), stored);
            for (std::size_t j = 0; j < components; ++j) {
                for (std::size_t k = 0; k < width; ++k) {
                    stored[(j + 1) * width + k] = cluster.basis[j * width + k] * (largest[j] / 127.0F);
                }
            }
            const std::size_t first = std::size_t{memory->cluster_blocks[at]} * block_points;
            for (std::size_t m = 0; m < members.size(); ++m) {
                const std::size_t slot = first + m;
                for (std::size_t j = 0; j < components; ++j) {
                    const float w = weights[m * components + j];
                    const auto integer =
                        static_cast<std::int8_t>(largest[j] > 0.0F ? std::lround(w / largest[j] * 127.0F) : 0);
                    std::memcpy(memory->blocks->data() + (slot / block_points * components + j) * block_points +
                                    slot % block_points,
                                &integer, 1);
                }
            }
        },
        settings.threads);

    TransferTable table;
    TransferInfo& info = table.info;
    info.kind = field.kind;
    info.encoding = Encoding::cpca;
    info.order = static_cast<std::uint32_t>(field.order);
    info.rows = static_cast<std::uint32_t>(field.rows());
    info.channels = static_cast<std::uint32_t>(field.channels);
    info.clusters = static_cast<std::uint32_t>(kept.size());
    info.components = static_cast<std::uint32_t>(components);
    info.count = field.count;
    info.slots = memory->slot_points.size();
    info.mesh_hash = field.mesh_hash;
    info.grid_size = field.grid.size;
    info.grid_origin_m = field.grid.origin_m;
    info.grid_step_m = field.grid.step_m;
    table.blocks = *memory->blocks;
    table.clusters = memory->clusters;
    table.cluster_blocks = memory->cluster_blocks;
    table.slot_points = memory->slot_points;
    table.owner = memory;
    const TransferField decoded = decode(table);
    fill_band_norms(decoded, info);
    info.encoding_rms = static_cast<float>(relative_rms(decoded, field));
    return table;
}

Result<TransferTable> encode_cpca_within(const TransferField& field, double max_error, std::size_t most,
                                         unsigned threads) {
    CpcaSettings settings;
    settings.threads = threads;
    // Means and bases should stay a small part of the whole.
    settings.clusters = std::clamp<std::size_t>(field.count / 250, 1, 256);
    std::size_t low = 1;
    std::size_t high = most;
    settings.components = most;
    Result<TransferTable> best = encode_cpca(field, settings);
    if (!best || static_cast<double>(best->info.encoding_rms) > max_error) {
        return best ? Result<TransferTable>(Error{"error is " + std::to_string(best->info.encoding_rms) + " with " +
                                                      std::to_string(most) + " components",
                                                  "CPCA", "at most " + std::to_string(max_error)})
                    : best;
    }
    while (low < high) {
        settings.components = (low + high) / 2;
        Result<TransferTable> table = encode_cpca(field, settings);
        if (table && static_cast<double>(table->info.encoding_rms) <= max_error) {
            high = settings.components;
            best = std::move(table);
        } else {
            low = settings.components + 1;
        }
    }
    return best;
}

} // namespace alpenglow::prt
