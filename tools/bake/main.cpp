// alpenglow-bake: bakes radiance transfer. docs/prt.md explains the options.
#include <alpenglow/core/timing.hpp>
#include <alpenglow/prt/bake_cubemap.hpp>
#include <alpenglow/prt/bake_glossy.hpp>
#include <alpenglow/prt/bake_neighbourhood.hpp>
#include <alpenglow/prt/compress.hpp>
#include <alpenglow/prt/import_mesh.hpp>
#include <alpenglow/prt/part_file.hpp>
#include <alpenglow/prt/shapes.hpp>
#include <alpenglow/prt/transfer_file.hpp>

#ifdef ALPENGLOW_HAVE_VULKAN
#include <alpenglow/prt/bake_cubemap_vulkan.hpp>
#include <alpenglow/vulkan/device.hpp>
#include <alpenglow/vulkan/instance.hpp>
#endif

#include "read_vdb.hpp"

#include <CLI/CLI.hpp>

#include <cmath>
#include <cstdio>
#include <fstream>

#include <unistd.h>

namespace alpenglow::bake {
namespace {

struct Options {
    std::string mesh;
    std::string out;
    std::string transport = "shadowed";
    std::string sampling = "adaptive";
    std::string encoding = "f16";
    double cpca_error = 0.01;
    prt::BakeSettings settings;
    int bounces = -1; // -1: not given
    bool glossy = false;
    int out_order = 0;
    float specular = 0.3F;
    float phong = 16.0F;
    std::string volume;
    unsigned volume_size = 48;
    float extinction_scale = 1.0F;
    float volume_albedo = 0.9F;
    std::vector<unsigned> neighbourhood;
    std::string report;
    std::string shard;
    std::size_t cube_maps = 0;
    bool gpu = false;
    bool z_up = false;
    bool quiet = false;
    std::vector<std::string> parts;
};

int fail(const Error& error) {
    std::fprintf(stderr, "alpenglow-bake: %s\n", error.message().c_str());
    return 1;
}

// A bar on a terminal, a line at every tenth elsewhere.
prt::ProgressCallback progress_bar(bool quiet) {
    if (quiet) {
        return {};
    }
    const bool terminal = isatty(fileno(stderr)) != 0;
    return [terminal, tenth = -1](const prt::Progress& p) mutable {
        if (terminal) {
            std::string bar(30, '.');
            std::fill_n(bar.begin(), static_cast<std::size_t>(30.0 * std::clamp(p.fraction, 0.0, 1.0)), '#');
            std::fprintf(stderr, "\r[%s] %3.0f %%  %s  %.0f s left   ", bar.c_str(), 100.0 * p.fraction, p.stage,
                         p.remaining_s);
        } else if (const int now = static_cast<int>(10.0 * p.fraction); now > tenth) {
            tenth = now;
            std::fprintf(stderr, "%d %% %s, %.0f s left\n", 10 * now, p.stage, p.remaining_s);
        }
        return true;
    };
}

// Names of procedural meshes work too: "shape:figure:50000".
Result<prt::Mesh> open_mesh(const Options& o) {
    if (o.mesh.rfind("shape:", 0) == 0) {
        const std::string rest = o.mesh.substr(6);
        const std::size_t colon = rest.find(':');
        const std::string name = rest.substr(0, colon);
        const int size = colon == std::string::npos ? 10000 : std::atoi(rest.c_str() + colon + 1);
        const int side = std::max(2, static_cast<int>(std::lround(std::sqrt(static_cast<double>(size)))));
        if (size < 4 || size > 50000000) {
            return Error{rest, "shape", "4 .. 50000000 vertices"};
        }
        if (name == "figure") {
            return prt::figure(size);
        }
        if (name == "torus") {
            return prt::torus(1.0F, 0.35F, side, side);
        }
        if (name == "bowl") {
            return prt::bowl(1.0F, side, side);
        }
        if (name == "sphere") {
            return prt::sphere(1.0F, std::max(1, side / 3));
        }
        if (name == "glider") {
            return prt::glider(1.0F);
        }
        return Error{name, "shape", "figure, torus, bowl, sphere or glider"};
    }
    return prt::import_mesh(o.mesh, {.y_up = !o.z_up});
}

int save(const Options& o, const prt::Bake& baked) {
    if (!o.quiet) {
        std::fprintf(stderr, "\n");
    }
    const Result<prt::TransferTable> table = [&]() -> Result<prt::TransferTable> {
        if (o.encoding == "cpca") {
            return prt::encode_cpca_within(baked.field, o.cpca_error, 48, o.settings.threads);
        }
        return prt::encode(baked.field, o.encoding == "f32"   ? prt::Encoding::f32
                                        : o.encoding == "f16" ? prt::Encoding::f16
                                                              : prt::Encoding::s8);
    }();
    if (!table) {
        return fail(table.error());
    }
    if (const Status status = prt::save_transfer(*table, o.out); !status) {
        return fail(status.error());
    }
    char line[200];
    std::snprintf(line, sizeof line, "encoding               %s, relative RMS error %.3g, %zu bytes\n",
                  o.encoding.c_str(), static_cast<double>(table->info.encoding_rms), table->bytes());
    const std::string text = baked.report.text() + line;
    if (!o.quiet) {
        std::fputs(text.c_str(), stdout);
    }
    if (!o.report.empty() && !(std::ofstream(o.report) << text)) {
        return fail({"cannot be written", o.report, ""});
    }
    return 0;
}

// Volumes come in shards of voxels, neighbourhoods of grid points, the rest of vertices.
struct Shard {
    std::size_t number = 0;
    std::size_t of = 0; // 0: no shards
};
Result<Shard> parse_shard(const std::string& text) {
    Shard shard;
    char rest = 0;
    if (!text.empty() && (std::sscanf(text.c_str(), "%zu/%zu%c", &shard.number, &shard.of, &rest) != 2 ||
                          shard.number < 1 || shard.number > shard.of)) {
        return Error{text, "--shard", "k/n with 1 <= k <= n"};
    }
    return shard;
}

Result<prt::VolumeDensity> open_volume(const Options& o) {
#ifdef ALPENGLOW_HAVE_OPENVDB
    return read_vdb(o.volume, o.volume_size, o.extinction_scale);
#else
    return Error{"this build has no OpenVDB", o.volume, "a build with it"};
#endif
}

// Saves the shard of a bake in parts, or bakes and saves all of it.
template <class Part, class Whole>
int run_fields(const Options& o, const Shard& shard, std::size_t points, prt::SavedFieldPart saved, const Part& part,
               const Whole& whole) {
    if (shard.of == 0) {
        const Result<prt::Bake> baked = whole();
        return baked ? save(o, *baked) : fail(baked.error());
    }
    const prt::ShardRange range = prt::shard_range(points, shard.number, shard.of);
    Result<prt::FieldPart> baked = part(range.first, range.last - range.first);
    if (!baked) {
        return fail(baked.error());
    }
    saved.part = std::move(*baked);
    const Status status = prt::save_field_part(saved, o.out);
    return status ? 0 : fail(status.error());
}

int merge_fields(const Options& o) {
    std::vector<prt::FieldPart> parts;
    prt::SavedFieldPart last;
    for (const std::string& path : o.parts) {
        Result<prt::SavedFieldPart> saved = prt::load_field_part(path);
        if (!saved) {
            return fail(saved.error());
        }
        parts.push_back(std::move(saved->part));
        last = std::move(*saved);
    }
    if (parts.front().kind == prt::TransferKind::volume) {
        const Result<prt::VolumeDensity> density = open_volume(o);
        if (!density) {
            return fail(density.error());
        }
        last.volume.threads = o.settings.threads;
        last.volume.progress = progress_bar(o.quiet);
        const Result<prt::Bake> baked = prt::finish_volume(*density, last.volume, std::move(parts));
        return baked ? save(o, *baked) : fail(baked.error());
    }
    const Result<prt::Mesh> mesh = open_mesh(o);
    if (!mesh) {
        return fail(mesh.error());
    }
    if (parts.front().kind == prt::TransferKind::glossy) {
        last.glossy.threads = o.settings.threads;
        last.glossy.progress = progress_bar(o.quiet);
        const Result<prt::Bake> baked = prt::finish_glossy(*mesh, last.glossy, std::move(parts));
        return baked ? save(o, *baked) : fail(baked.error());
    }
    const Result<prt::Bake> baked = prt::finish_neighbourhood(*mesh, last.grid, last.neighbourhood, std::move(parts));
    return baked ? save(o, *baked) : fail(baked.error());
}

int run_merge(Options o) {
    if (prt::part_file_kind(o.parts.front()) == 'f') {
        return merge_fields(o);
    }
    const Result<prt::Mesh> mesh = open_mesh(o);
    if (!mesh) {
        return fail(mesh.error());
    }
    std::vector<prt::BakePart> parts;
    prt::BakeSettings settings;
    for (const std::string& path : o.parts) {
        Result<prt::SavedPart> saved = prt::load_part(path);
        if (!saved) {
            return fail(saved.error());
        }
        settings = saved->settings;
        parts.push_back(std::move(saved->part));
    }
    settings.threads = o.settings.threads;
    settings.progress = progress_bar(o.quiet);
    const Result<prt::Bake> baked = prt::finish(*mesh, settings, std::move(parts));
    return baked ? save(o, *baked) : fail(baked.error());
}

int run_volume(const Options& o, const Shard& shard) {
    const Result<prt::VolumeDensity> density = open_volume(o);
    if (!density) {
        return fail(density.error());
    }
    prt::SavedFieldPart saved;
    prt::VolumeSettings& volume = saved.volume;
    volume.order = o.settings.order;
    volume.albedo = o.volume_albedo;
    volume.threads = o.settings.threads;
    volume.progress = o.settings.progress;
    if (o.bounces >= 0) {
        volume.max_bounces = o.bounces;
    }
    return run_fields(
        o, shard, density->extinction_per_m.size(), saved,
        [&](std::size_t first, std::size_t count) { return prt::bake_volume_part(*density, volume, first, count); },
        [&] { return prt::bake_volume(*density, volume); });
}

int run_glossy(const Options& o, const Shard& shard, const prt::Mesh& mesh) {
    prt::SavedFieldPart saved;
    prt::GlossySettings& glossy = saved.glossy;
    glossy.transport = o.settings.transport;
    glossy.order = o.settings.order;
    glossy.out_order = o.out_order == 0 ? 5 : o.out_order;
    glossy.rays = o.settings.rays;
    glossy.default_albedo = o.settings.default_albedo;
    glossy.specular = o.specular;
    glossy.phong_exponent = o.phong;
    glossy.max_bounces = o.settings.max_bounces;
    glossy.seed = o.settings.seed;
    glossy.threads = o.settings.threads;
    glossy.progress = o.settings.progress;
    return run_fields(
        o, shard, mesh.positions.size(), saved,
        [&](std::size_t first, std::size_t count) { return prt::bake_glossy_part(mesh, glossy, first, count); },
        [&] { return prt::bake_glossy(mesh, glossy); });
}

int run_neighbourhood(const Options& o, const Shard& shard, const prt::Mesh& mesh) {
    prt::SavedFieldPart saved;
    prt::NeighbourhoodSettings& around = saved.neighbourhood;
    around.order = o.settings.order;
    around.out_order = o.out_order == 0 ? 3 : o.out_order;
    around.rays = o.settings.rays;
    around.bounce = o.settings.transport == prt::Transport::interreflected;
    around.default_albedo = o.settings.default_albedo;
    around.seed = o.settings.seed;
    around.threads = o.settings.threads;
    around.progress = o.settings.progress;
    const glm::uvec3 size(o.neighbourhood[0], o.neighbourhood[1], o.neighbourhood[2]);
    saved.grid = prt::grid_around(mesh, size, 1.0F, 0.2F, 2.0F);
    return run_fields(
        o, shard, std::size_t{size.x} * size.y * size.z, saved,
        [&](std::size_t first, std::size_t count) {
            return prt::bake_neighbourhood_part(mesh, saved.grid, around, first, count);
        },
        [&] { return prt::bake_neighbourhood(mesh, saved.grid, around); });
}

// By cube maps; the report says how far they are from rays.
int run_cube_maps(const Options& o, const prt::Mesh& mesh) {
    const prt::BakeSettings& s = o.settings;
    const Result<prt::Bake> baked = [&]() -> Result<prt::Bake> {
        if (!o.gpu) {
            return prt::bake_cubemap(mesh, s, o.cube_maps);
        }
#ifdef ALPENGLOW_HAVE_VULKAN
        const Result<vulkan::Instance> instance = vulkan::Instance::create({.application = "alpenglow-bake"});
        if (!instance) {
            return instance.error();
        }
        const Result<vulkan::Device> device = vulkan::Device::create(*instance);
        return device ? prt::bake_cubemap(*device, mesh, s, o.cube_maps) : Result<prt::Bake>(device.error());
#else
        return Error{"this build has no Vulkan", "--gpu", "a build with it"};
#endif
    }();
    if (!baked) {
        return fail(baked.error());
    }
    if (!o.quiet) {
        const Result<prt::Bake> rays = prt::bake(mesh, s);
        if (rays) {
            double sum = 0.0;
            for (std::size_t i = 0; i < rays->field.values.size(); ++i) {
                const double d =
                    static_cast<double>(rays->field.values[i]) - static_cast<double>(baked->field.values[i]);
                sum += d * d;
            }
            std::vector<float> open(static_cast<std::size_t>(s.order * s.order));
            prt::unshadowed(s.order, glm::vec3(0.0F, 0.0F, 1.0F), open);
            double one = 0.0;
            for (const float x : open) {
                one += static_cast<double>(x) * static_cast<double>(x);
            }
            std::printf("\nRMS error against rays %.3g (their own estimate %.3g)\n",
                        std::sqrt(sum / static_cast<double>(rays->field.count) / one), rays->report.estimated_rms);
        }
    }
    return save(o, *baked);
}

int run_bake(Options o) {
    prt::BakeSettings& s = o.settings;
    s.progress = progress_bar(o.quiet);
    const Result<Shard> shard = parse_shard(o.shard);
    if (!shard) {
        return fail(shard.error());
    }
    if (!o.volume.empty()) {
        return run_volume(o, *shard);
    }
    const Result<prt::Mesh> mesh = open_mesh(o);
    if (!mesh) {
        return fail(mesh.error());
    }
    s.transport = o.transport == "unshadowed"       ? prt::Transport::unshadowed
                  : o.transport == "interreflected" ? prt::Transport::interreflected
                                                    : prt::Transport::shadowed;
    if (o.bounces >= 0) {
        s.max_bounces = o.bounces;
        if (o.bounces > 0) {
            s.transport = prt::Transport::interreflected;
        }
    }
    s.sampling = o.sampling == "random"       ? prt::Sampling::random
                 : o.sampling == "stratified" ? prt::Sampling::stratified
                 : o.sampling == "fibonacci"  ? prt::Sampling::fibonacci
                                              : prt::Sampling::adaptive;
    if (o.glossy) {
        return run_glossy(o, *shard, *mesh);
    }
    if (!o.neighbourhood.empty()) {
        return run_neighbourhood(o, *shard, *mesh);
    }
    if (o.cube_maps > 0) {
        if (shard->of > 0) {
            return fail({"cube maps are baked whole", "--shard", "no --cube-maps"});
        }
        return run_cube_maps(o, *mesh);
    }
    if (shard->of == 0) {
        const Result<prt::Bake> baked = prt::bake(*mesh, s);
        return baked ? save(o, *baked) : fail(baked.error());
    }
    const prt::ShardRange range = prt::shard_range(mesh->positions.size(), shard->number, shard->of);
    const Result<prt::BakePart> part = prt::bake_part(*mesh, s, range.first, range.last - range.first);
    if (!part) {
        return fail(part.error());
    }
    const Status status = prt::save_part(s, *part, o.out);
    return status ? 0 : fail(status.error());
}

} // namespace
} // namespace alpenglow::bake

int main(int argc, char** argv) {
    using namespace alpenglow::bake;
    Options o;
    CLI::App app("Bakes radiance transfer: mesh in, transfer file out", "alpenglow-bake");
    app.get_formatter()->column_width(34);
    const auto common = [&](CLI::App& to) {
        to.add_option("mesh", o.mesh, "OBJ or glTF file, or shape:figure:50000");
        to.add_option("-o,--out", o.out, "file to write")->required();
        to.add_option("--encoding", o.encoding)
            ->check(CLI::IsMember({"f32", "f16", "s8", "cpca"}))
            ->capture_default_str();
        to.add_option("--cpca-error", o.cpca_error, "relative RMS error that CPCA may cause")->capture_default_str();
        to.add_option("--report", o.report, "write the bake's report to this file");
        to.add_option("--threads", o.settings.threads, "0: all");
        to.add_flag("--z-up", o.z_up, "the mesh file's +Z is up, not its +Y");
        to.add_flag("--quiet", o.quiet);
        to.add_option("--volume", o.volume, "bake this OpenVDB file instead of a mesh");
        to.add_option("--volume-size", o.volume_size, "voxels along the longest axis")
            ->check(CLI::Range(2, 512))
            ->capture_default_str();
        to.add_option("--extinction-scale", o.extinction_scale, "density -> extinction per metre")
            ->capture_default_str();
    };
    common(app);
    app.add_option("--order", o.settings.order, "bands of the light")->check(CLI::Range(1, 6))->capture_default_str();
    app.add_option("--transport", o.transport)
        ->check(CLI::IsMember({"unshadowed", "shadowed", "interreflected"}))
        ->capture_default_str();
    app.add_option("--bounces", o.bounces, "at most this many; more than 0 means interreflected")
        ->check(CLI::NonNegativeNumber);
    app.add_option("--max-error", o.settings.max_error, "relative RMS error to stop at")->capture_default_str();
    app.add_option("--rays", o.settings.rays, "most rays a point")->capture_default_str();
    app.add_option("--gather-rays", o.settings.gather_rays, "rays a point for bounces")->capture_default_str();
    app.add_option("--sampling", o.sampling)
        ->check(CLI::IsMember({"random", "stratified", "fibonacci", "adaptive"}))
        ->capture_default_str();
    app.add_flag("--colour", o.settings.colour, "RGB transfer: colours bleed");
    app.add_option("--albedo", o.settings.default_albedo, "of meshes without material")->capture_default_str();
    app.add_option("--seed", o.settings.seed)->capture_default_str();
    app.add_flag("--glossy", o.glossy, "transfer matrices");
    app.add_option("--out-order", o.out_order, "rows of matrices: 5 for --glossy, 3 for --neighbourhood");
    app.add_option("--specular", o.specular, "glossy: part that the lobe reflects, for bounces")->capture_default_str();
    app.add_option("--phong", o.phong, "glossy: exponent of the lobe, for bounces")->capture_default_str();
    app.add_option("--volume-albedo", o.volume_albedo, "single scattering")->capture_default_str();
    app.add_option("--neighbourhood", o.neighbourhood, "bake a grid of x y z points around the mesh")->expected(3);
    app.add_option("--cube-maps", o.cube_maps, "bake without rays, by cube maps of this many texels a side")
        ->check(CLI::Range(4, 128));
    app.add_flag("--gpu", o.gpu, "cube maps are drawn by the Vulkan device");
    app.add_option("--shard", o.shard, "k/n: bake the k-th of n parts; join with merge");
    CLI::App* merge = app.add_subcommand("merge", "joins parts made with --shard to a transfer file");
    common(*merge);
    merge->add_option("--parts", o.parts, "all parts, in any order")->required();
    // `merge` has its own mesh and --out.
    app.get_option("--out")->required(false);
    CLI11_PARSE(app, argc, argv);
    if (o.out.empty()) {
        std::fprintf(stderr, "alpenglow-bake: --out is required\n");
        return 1;
    }
    if (o.mesh.empty() && o.volume.empty()) {
        std::fprintf(stderr, "alpenglow-bake: a mesh or --volume is required\n");
        return 1;
    }
    return merge->parsed() ? run_merge(o) : run_bake(o);
}
