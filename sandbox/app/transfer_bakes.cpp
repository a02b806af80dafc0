#include "sandbox/app/transfer_bakes.hpp"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <system_error>
#include <type_traits>
#include <utility>

#include <alpenglow/prt/hash.hpp>
#include <alpenglow/prt/transfer_file.hpp>

namespace alpenglow::sandbox {
namespace {

constexpr std::uint64_t recipe = 1; // raise it when a bake's result changes for the same input

// What a bake is kept under: the recipe, the kind of bake, and all that its result depends on.
template <class... Values>
std::uint64_t key_of(const Values&... values) {
    static_assert((std::is_trivially_copyable_v<Values> && ...));
    prt::Hasher hasher;
    hasher.add(std::as_bytes(std::span(&recipe, 1)));
    (hasher.add(std::as_bytes(std::span(&values, 1))), ...);
    return hasher.digest();
}

Result<std::shared_ptr<const prt::TransferTable>> shared(const prt::TransferField& field) {
    Result<prt::TransferTable> table = prt::encode(field, prt::Encoding::f16);
    if (!table) {
        return table.error();
    }
    return std::make_shared<const prt::TransferTable>(std::move(table).value());
}

// Encodes fields by level; an empty one gives no table.
Result<TransferTables> encoded(const std::array<prt::TransferField, 3>& fields) {
    TransferTables tables;
    for (std::size_t level = 0; level < fields.size(); ++level) {
        if (fields[level].count == 0) {
            continue;
        }
        Result<std::shared_ptr<const prt::TransferTable>> table = shared(fields[level]);
        if (!table) {
            return table.error();
        }
        tables[level] = std::move(table).value();
    }
    return tables;
}

// A part of a longer bake's progress.
prt::ProgressCallback part_of(const prt::ProgressCallback& whole, double from, double to) {
    return [&whole, from, to](const prt::Progress& progress) {
        prt::Progress scaled = progress;
        scaled.fraction = from + (to - from) * progress.fraction;
        return whole(scaled);
    };
}

prt::TransferField unshadowed_field(const prt::Mesh& mesh, int order) {
    prt::TransferField field;
    field.order = order;
    field.count = mesh.positions.size();
    field.mesh_hash = prt::mesh_hash(mesh);
    field.values.resize(field.count * field.width());
    for (std::size_t i = 0; i < field.count; ++i) {
        prt::unshadowed(order, mesh.normals[i], field.point(i));
    }
    return field;
}

} // namespace

Result<prt::TransferTable> unshadowed_table(const prt::Mesh& mesh, int order) {
    return prt::encode(unshadowed_field(mesh, order), prt::Encoding::f16);
}

BakeJob diffuse_job(std::string name, prt::Mesh mesh, prt::BakeSettings settings) {
    settings.transport = prt::Transport::interreflected;
    const std::uint64_t key =
        key_of('d', prt::mesh_hash(mesh), settings.order, settings.sampling, settings.rays, settings.max_error,
               settings.gather_rays, settings.max_bounces, settings.stop_energy, settings.colour, settings.seed);
    return {std::move(name), key,
            [mesh = std::move(mesh), settings](const prt::ProgressCallback& progress) -> Result<TransferTables> {
                prt::BakeSettings s = settings;
                s.progress = part_of(progress, 0.0, 0.9);
                Result<prt::BakePart> part = prt::bake_part(mesh, s, 0, mesh.positions.size());
                if (!part) {
                    return part.error();
                }
                std::array<prt::TransferField, 3> fields;
                fields[0] = unshadowed_field(mesh, s.order);
                fields[1] = fields[0]; // and the direct part of the rays in place of the cosine
                fields[1].values = part->direct;
                std::vector<prt::BakePart> parts;
                parts.push_back(std::move(part).value());
                s.progress = part_of(progress, 0.9, 1.0);
                Result<prt::Bake> baked = prt::finish(mesh, s, std::move(parts));
                if (!baked) {
                    return baked.error();
                }
                fields[2] = std::move(baked).value().field;
                return encoded(fields);
            }};
}

BakeJob glossy_job(std::string name, prt::Mesh mesh, prt::GlossySettings settings) {
    const std::uint64_t key =
        key_of('g', prt::mesh_hash(mesh), settings.order, settings.out_order, settings.rays, settings.gather_rays,
               settings.max_bounces, settings.stop_energy, settings.specular, settings.phong_exponent, settings.seed);
    return {std::move(name), key,
            [mesh = std::move(mesh), settings](const prt::ProgressCallback& progress) -> Result<TransferTables> {
                std::array<prt::TransferField, 3> fields;
                for (int level = 0; level < 3; ++level) {
                    prt::GlossySettings s = settings;
                    s.transport = static_cast<prt::Transport>(level);
                    s.progress = part_of(progress, level / 3.0, (level + 1) / 3.0);
                    Result<prt::Bake> baked = prt::bake_glossy(mesh, s);
                    if (!baked) {
                        return baked.error();
                    }
                    fields[static_cast<std::size_t>(level)] = std::move(baked).value().field;
                }
                return encoded(fields);
            }};
}

BakeJob neighbourhood_job(std::string name, prt::Mesh mesh, const prt::Grid& grid,
                          prt::NeighbourhoodSettings settings) {
    const std::uint64_t key =
        key_of('n', prt::mesh_hash(mesh), grid, settings.order, settings.out_order, settings.rays, settings.seed);
    return {std::move(name), key,
            [mesh = std::move(mesh), grid, settings](const prt::ProgressCallback& progress) -> Result<TransferTables> {
                std::array<prt::TransferField, 3> fields;
                for (int level = 1; level < 3; ++level) {
                    prt::NeighbourhoodSettings s = settings;
                    s.bounce = level == 2;
                    s.progress = part_of(progress, 0.5 * (level - 1), 0.5 * level);
                    Result<prt::Bake> baked = prt::bake_neighbourhood(mesh, grid, s);
                    if (!baked) {
                        return baked.error();
                    }
                    fields[static_cast<std::size_t>(level)] = std::move(baked).value().field;
                }
                return encoded(fields);
            },
            1};
}

BakeJob volume_job(std::string name, prt::VolumeDensity density, prt::VolumeSettings settings) {
    prt::Hasher matter;
    matter.add_values(std::span<const float>(density.extinction_per_m));
    const std::uint64_t key = key_of('v', density.grid, matter.digest(), settings.order, settings.directions,
                                     settings.albedo, settings.max_bounces, settings.stop_energy);
    return {std::move(name), key,
            [density = std::move(density), settings](const prt::ProgressCallback& progress) -> Result<TransferTables> {
                std::array<prt::TransferField, 3> fields;
                for (int level = 1; level < 3; ++level) {
                    prt::VolumeSettings s = settings;
                    s.max_bounces = level == 1 ? 0 : settings.max_bounces;
                    s.progress = part_of(progress, level == 1 ? 0.0 : 0.2, level == 1 ? 0.2 : 1.0);
                    Result<prt::Bake> baked = prt::bake_volume(density, s);
                    if (!baked) {
                        return baked.error();
                    }
                    fields[static_cast<std::size_t>(level)] = std::move(baked).value().field;
                }
                fields[0] = fields[1]; // all light arrives everywhere: its mean
                std::fill(fields[0].values.begin(), fields[0].values.end(), 0.0F);
                for (std::size_t i = 0; i < fields[0].count; ++i) {
                    fields[0].point(i)[0] = 0.28209479F; // (1/4pi) int y_0
                }
                return encoded(fields);
            }};
}

std::filesystem::path cache_folder() {
    const auto named = [](const char* variable) {
        const char* value = std::getenv(variable);
        return std::filesystem::path(value != nullptr ? value : "");
    };
    if (const std::filesystem::path cache = named("XDG_CACHE_HOME"); cache.is_absolute()) {
        return cache / "alpenglow";
    }
    if (const std::filesystem::path home = named("HOME"); home.is_absolute()) {
        return home / ".cache" / "alpenglow";
    }
    return {};
}

TransferBakes::TransferBakes(std::vector<BakeJob> jobs, std::filesystem::path cache)
    : jobs_(std::move(jobs)), cache_(std::move(cache)), tables_(jobs_.size()) {
    if (!cache_.empty()) {
        std::error_code failed;
        std::filesystem::create_directories(cache_, failed);
        if (failed) {
            state_.problem = "no cache in " + cache_.string() + ": " + failed.message();
            cache_.clear();
        }
    }
    thread_ = std::thread([this] { run(); });
}

TransferBakes::~TransferBakes() {
    cancel_ = true;
    wait();
}

void TransferBakes::wait() {
    if (thread_.joinable()) {
        thread_.join();
    }
}

TransferBakes::State TransferBakes::state() const {
    const std::lock_guard lock(mutex_);
    return state_;
}

bool TransferBakes::take(std::size_t job, TransferTables& tables) const {
    const std::lock_guard lock(mutex_);
    if (job >= state_.done) {
        return false;
    }
    tables = tables_[job];
    return true;
}

std::filesystem::path TransferBakes::file(const BakeJob& job, std::size_t level) const {
    std::array<char, 40> name{};
    std::snprintf(name.data(), name.size(), "%016llx-%zu.transfer", static_cast<unsigned long long>(job.key), level);
    return cache_ / name.data();
}

// True where all files are there and sound.
bool TransferBakes::load(const BakeJob& job, TransferTables& tables) const {
    if (cache_.empty()) {
        return false;
    }
    for (std::size_t level = job.first_level; level < tables.size(); ++level) {
        Result<prt::TransferTable> table = prt::load_transfer(file(job, level));
        if (!table) {
            return false;
        }
        tables[level] = std::make_shared<const prt::TransferTable>(std::move(table).value());
    }
    return true;
}

void TransferBakes::keep(const BakeJob& job, const TransferTables& tables) {
    for (std::size_t level = 0; level < tables.size() && !cache_.empty(); ++level) {
        if (tables[level] == nullptr) {
            continue;
        }
        if (const Status saved = prt::save_transfer(*tables[level], file(job, level)); !saved) {
            const std::lock_guard lock(mutex_);
            state_.problem = state_.problem.empty() ? saved.error().message() : state_.problem;
            cache_.clear(); // full or not writable: the rest would fare no better
        }
    }
}

void TransferBakes::run() {
    for (std::size_t i = 0; i < jobs_.size() && !cancel_; ++i) {
        const BakeJob& job = jobs_[i];
        {
            const std::lock_guard lock(mutex_);
            state_.job = job.name;
            state_.fraction = 0.0;
        }
        TransferTables tables;
        const bool cached = load(job, tables);
        bool failed = false;
        if (!cached) {
            Result<TransferTables> baked = job.bake([this](const prt::Progress& progress) {
                const std::lock_guard lock(mutex_);
                state_.fraction = progress.fraction;
                return !cancel_.load();
            });
            if (cancel_) {
                return;
            }
            failed = !baked;
            if (baked) {
                tables = std::move(baked).value();
                keep(job, tables);
            } else {
                tables = {};
                const std::lock_guard lock(mutex_);
                state_.problem = job.name + ": " + baked.error().message();
            }
        }
        const std::lock_guard lock(mutex_);
        tables_[i] = std::move(tables);
        state_.from_cache += cached ? 1 : 0;
        state_.failed += failed ? 1 : 0;
        ++state_.done;
    }
    const std::lock_guard lock(mutex_);
    state_.job.clear();
    state_.fraction = 1.0;
}

} // namespace alpenglow::sandbox
