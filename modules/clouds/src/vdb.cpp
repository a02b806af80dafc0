#include <alpenglow/clouds/vdb.hpp>

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <mutex>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#include <openvdb/io/Stream.h>
#include <openvdb/math/Ray.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/RayIntersector.h>
#pragma GCC diagnostic pop

namespace alpenglow::clouds {
namespace {

void initialise() {
    static std::once_flag once;
    std::call_once(once, [] { openvdb::initialize(); });
}

const openvdb::FloatGrid& float_grid(const VdbGrid& grid) {
    assert(grid.grid);
    return *static_cast<const openvdb::FloatGrid*>(grid.grid.get());
}

// OpenVDB reads past some damage without a word; these are the cases worth a sentence of their own.
Status check_file(const std::string& path) {
    std::error_code failure;
    if (!std::filesystem::exists(path, failure)) {
        return Error{"no such file", path, "a .vdb file"};
    }
    if (std::filesystem::is_directory(path, failure)) {
        return Error{"is a directory", path, "a .vdb file"};
    }
    std::ifstream file(path, std::ios::binary);
    unsigned char magic[8] = {};
    if (!file.read(reinterpret_cast<char*>(magic), sizeof magic)) {
        return Error{"truncated: shorter than the 8 bytes of a .vdb header", path, "a whole .vdb file"};
    }
    const unsigned char wanted[8] = {0x20, 0x42, 0x44, 0x56, 0, 0, 0, 0}; // " BDV" and four zeros
    if (!std::equal(wanted, wanted + 8, magic)) {
        return Error{"wrong magic number", path, "a file that starts with OpenVDB's magic number 0x56444220"};
    }
    return Ok{};
}

template <class F>
auto guarded(const std::string& path, F&& body) -> decltype(body()) {
    try {
        initialise();
        return body();
    } catch (const std::bad_alloc&) {
        return Error{"asks for more memory than there is", path, "an intact .vdb file that fits in memory"};
    } catch (const std::exception& failure) {
        return Error{std::string("cannot be read: ") + failure.what(), path, "an intact .vdb file"};
    }
}

Result<GridTransform> transform_of(const openvdb::FloatGrid& grid, const std::string& where) {
    const char* const expected = "a linear transform of rotation, translation and scale";
    if (!grid.transform().isLinear()) {
        return Error{"the grid's transform is a frustum", where, expected};
    }
    GridTransform out;
    const auto column = [&](double x, double y, double z) {
        const openvdb::Vec3d at = grid.transform().indexToWorld(openvdb::Vec3d(x, y, z));
        return glm::dvec3(at.x(), at.y(), at.z());
    };
    out.origin_m = column(0, 0, 0);
    for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec3 v = column(axis == 0, axis == 1, axis == 2) - out.origin_m;
        const double length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
        if (!(length > 0.0) || !std::isfinite(length)) {
            return Error{"the grid's voxel size is " + std::to_string(length), where, "a finite size above 0"};
        }
        out.voxel_m[axis] = length;
        out.axes[axis] = v / length;
    }
    for (int a = 0; a < 3; ++a) {
        const glm::dvec3& u = out.axes[a];
        const glm::dvec3& v = out.axes[(a + 1) % 3];
        if (std::abs(u.x * v.x + u.y * v.y + u.z * v.z) > 1e-6) {
            return Error{"the grid's transform shears", where, expected};
        }
    }
    return out;
}

std::string at(const openvdb::Coord& c) {
    return "(" + std::to_string(c.x()) + ", " + std::to_string(c.y()) + ", " + std::to_string(c.z()) + ")";
}

} // namespace

std::string VdbGrid::name() const {
    return float_grid(*this).getName();
}
std::size_t VdbGrid::memory_bytes() const {
    return float_grid(*this).memUsage();
}
std::size_t VdbGrid::active_voxels() const {
    return float_grid(*this).activeVoxelCount();
}

Result<std::vector<VdbGridInfo>> list_vdb(const std::string& path) {
    if (Status ok = check_file(path); !ok) {
        return ok.error();
    }
    return guarded(path, [&]() -> Result<std::vector<VdbGridInfo>> {
        openvdb::io::File file(path);
        file.open(false);
        std::vector<VdbGridInfo> infos;
        for (auto name = file.beginName(); name != file.endName(); ++name) {
            const openvdb::GridBase::Ptr grid = file.readGridMetadata(name.gridName());
            VdbGridInfo info{name.gridName(), grid->valueType(), glm::ivec3(0), glm::ivec3(0)};
            const auto low = grid->getMetadata<openvdb::Vec3IMetadata>("file_bbox_min");
            const auto high = grid->getMetadata<openvdb::Vec3IMetadata>("file_bbox_max");
            if (low && high) {
                info.min = {low->value().x(), low->value().y(), low->value().z()};
                info.max = {high->value().x(), high->value().y(), high->value().z()};
            }
            infos.push_back(info);
        }
        return infos;
    });
}

Result<VdbGrid> load_vdb(const std::string& path, const std::string& grid_name) {
    auto infos = list_vdb(path);
    if (!infos) {
        return infos.error();
    }
    const VdbGridInfo* chosen = nullptr;
    std::string names;
    for (const VdbGridInfo& info : *infos) {
        names += (names.empty() ? "" : ", ") + ("'" + info.name + "' (" + info.value_type + ")");
        const bool is_float = info.value_type == "float";
        if (grid_name.empty() ? is_float && (chosen == nullptr || info.name == "density") : info.name == grid_name) {
            chosen = &info;
        }
    }
    const std::string holds = names.empty() ? "no grid" : names;
    if (chosen == nullptr) {
        return Error{grid_name.empty() ? "has no float grid: it holds " + holds
                                       : "has no grid '" + grid_name + "': it holds " + holds,
                     path, "a float grid of density"};
    }
    if (chosen->value_type != "float") {
        return Error{"grid '" + chosen->name + "' is of type " + chosen->value_type, path, "a float grid of density"};
    }
    return guarded(path, [&]() -> Result<VdbGrid> {
        // io::File takes short reads at the end of a cut file for zeros; a stream that throws does not.
        std::ifstream stream(path, std::ios::binary);
        stream.exceptions(std::ios::failbit | std::ios::badbit);
        openvdb::io::Stream reader(stream, false);
        openvdb::FloatGrid::Ptr grid;
        for (const openvdb::GridBase::Ptr& candidate : *reader.getGrids()) {
            if (candidate->getName() == chosen->name) {
                grid = openvdb::gridPtrCast<openvdb::FloatGrid>(candidate);
            }
        }
        if (!grid) {
            return Error{"grid '" + chosen->name + "' is listed but not there", path, "an intact .vdb file"};
        }
        if (grid->getGridClass() == openvdb::GRID_LEVEL_SET) {
            return Error{"grid '" + chosen->name + "' is a level set", path, "a fog volume: density, 0 outside"};
        }
        return VdbGrid{grid};
    });
}

Status save_vdb(const std::string& path, std::span<const VdbGrid> grids) {
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    std::error_code failure;
    if (!folder.empty() && !std::filesystem::is_directory(folder, failure)) {
        return Error{"the folder does not exist", path, "a path in an existing folder"};
    }
    try {
        initialise();
        openvdb::GridCPtrVec list;
        for (const VdbGrid& grid : grids) {
            list.push_back(std::static_pointer_cast<const openvdb::FloatGrid>(grid.grid));
        }
        openvdb::io::File file(path);
        file.write(list);
        return Ok{};
    } catch (const std::exception& problem) {
        return Error{std::string("cannot be written: ") + problem.what(), path,
                     "a writable path with room on the disk"};
    }
}

Result<SparseGrid> sparse_from_vdb(const VdbGrid& handle, const std::string& where, const VdbLimits& limits) {
    const openvdb::FloatGrid& grid = float_grid(handle);
    auto transform = transform_of(grid, where);
    if (!transform) {
        return transform.error();
    }
    if (grid.background() != 0.0F) {
        return Error{"the background is " + std::to_string(grid.background()), where, "0 outside the cloud"};
    }
    openvdb::CoordBBox box;
    if (!grid.tree().evalActiveVoxelBoundingBox(box)) {
        return SparseGrid({0, 0, 0}, {0, 0, 0}, *transform); // an empty cloud is a cloud
    }
    for (int axis = 0; axis < 3; ++axis) {
        const long extent = long(box.max().asPointer()[axis]) - long(box.min().asPointer()[axis]) + 1;
        if (extent > BrickTable::max_axis_voxels - 8) {
            return Error{"spans " + std::to_string(extent) + " voxels on axis " + std::to_string(axis), where,
                         "at most " + std::to_string(BrickTable::max_axis_voxels - 8) + ": split or coarsen it"};
        }
    }
    const std::size_t bytes =
        grid.activeVoxelCount() / SparseGrid::brick_voxels * SparseGrid::brick_voxels * sizeof(float);
    if (bytes > limits.max_bytes) {
        return Error{"its active tiles and voxels take " + std::to_string(bytes >> 20) + " MiB", where,
                     "at most " + std::to_string(limits.max_bytes >> 20) + " MiB"};
    }
    const openvdb::Coord low = box.min();
    const openvdb::Coord size = box.max() - box.min() + openvdb::Coord(1);
    SparseGrid out({low.x(), low.y(), low.z()}, {size.x(), size.y(), size.z()}, *transform);
    const glm::ivec3 min = out.min();

    Status good = Ok{};
    const auto checked = [&](float v, const openvdb::Coord& where_in_grid) {
        if (std::isfinite(v) && v >= 0.0F) {
            return true;
        }
        if (good) {
            const std::string value = std::isnan(v) ? "NaN" : std::to_string(v);
            good = Error{"density " + value + " at voxel " + at(where_in_grid), where, "finite densities >= 0"};
        }
        return false;
    };
    // Leaves are bricks of 8^3 on the same lattice; VDB's order inside them is z fastest.
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        if (leaf->onVoxelCount() == 0) {
            continue;
        }
        const openvdb::Coord origin = leaf->origin();
        float* to = out.brick((origin.x() - min.x) >> 3, (origin.y() - min.y) >> 3, (origin.z() - min.z) >> 3);
        for (auto value = leaf->cbeginValueOn(); value; ++value) {
            const openvdb::Coord c = value.getCoord();
            if (!checked(*value, c)) {
                return good.error();
            }
            to[((c.z() & 7) * 8 + (c.y() & 7)) * 8 + (c.x() & 7)] = *value;
        }
    }
    auto tile = grid.tree().cbeginValueOn();
    tile.setMaxDepth(openvdb::FloatTree::ValueOnCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile) {
        const openvdb::CoordBBox covered = tile.getBoundingBox();
        if (!checked(*tile, covered.min())) {
            return good.error();
        }
        for (int z = covered.min().z(); z <= covered.max().z(); z += 8) {
            for (int y = covered.min().y(); y <= covered.max().y(); y += 8) {
                for (int x = covered.min().x(); x <= covered.max().x(); x += 8) {
                    std::fill_n(out.brick((x - min.x) >> 3, (y - min.y) >> 3, (z - min.z) >> 3),
                                SparseGrid::brick_voxels, *tile);
                }
            }
        }
    }
    out.prune();
    return out;
}

VdbGrid vdb_from_sparse(const SparseGrid& from, const std::string& name) {
    initialise();
    const auto grid = openvdb::FloatGrid::create(0.0F);
    grid->setName(name);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    const GridTransform& t = from.transform();
    openvdb::math::Mat4d matrix = openvdb::math::Mat4d::identity();
    for (int row = 0; row < 3; ++row) { // OpenVDB multiplies row vectors
        for (int column = 0; column < 3; ++column) {
            matrix(row, column) = t.axes[row][column] * t.voxel_m[row];
        }
        matrix(3, row) = t.origin_m[row];
    }
    grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    const glm::ivec3 min = from.min();
    for (std::int32_t b = 0; b < from.table().count(); ++b) {
        const glm::ivec3 c = min + from.table().coordinates()[std::size_t(b)] * 8;
        const float* values = from.brick(b);
        openvdb::FloatTree::LeafNodeType* leaf = nullptr;
        for (int i = 0; i < SparseGrid::brick_voxels; ++i) {
            if (values[i] > 0.0F) {
                const openvdb::Coord at_voxel(c.x + (i & 7), c.y + ((i >> 3) & 7), c.z + (i >> 6));
                if (leaf == nullptr) {
                    leaf = grid->tree().touchLeaf(at_voxel);
                }
                leaf->setValueOn(at_voxel, values[i]);
            }
        }
    }
    return {grid};
}

void sample_vdb(const VdbGrid& handle, std::span<const glm::vec3> index, std::span<float> density) {
    const openvdb::FloatGrid& grid = float_grid(handle);
    assert(index.size() == density.size());
    auto accessor = grid.getConstAccessor();
    for (std::size_t i = 0; i < index.size(); ++i) {
        density[i] = openvdb::tools::BoxSampler::sample(accessor, openvdb::Vec3d(index[i].x, index[i].y, index[i].z));
    }
}

void march_vdb(const VdbGrid& handle, std::span<const glm::vec3> origins, std::span<const glm::vec3> directions,
               float step, bool (*add)(void* user, std::size_t ray, float t, float density), void* user) {
    const openvdb::FloatGrid& grid = float_grid(handle);
    if (grid.tree().empty() || origins.empty()) {
        return;
    }
    // The intersector works in the world of the grid's transform, which must have uniform voxels there: a copy that
    // shares the tree and has the identity for a transform turns index space into that world.
    const openvdb::FloatGrid::ConstPtr indexed =
        grid.copyReplacingTransform(openvdb::math::Transform::createLinearTransform(1.0));
    openvdb::tools::VolumeRayIntersector<openvdb::FloatGrid> intersector(*indexed,
                                                                         1); // dilated: BoxSampler reads neighbours
    auto accessor = indexed->getConstAccessor();
    for (std::size_t ray = 0; ray < origins.size(); ++ray) {
        const openvdb::Vec3d eye(origins[ray].x, origins[ray].y, origins[ray].z);
        const openvdb::Vec3d direction(directions[ray].x, directions[ray].y, directions[ray].z);
        if (!intersector.setIndexRay(openvdb::math::Ray<double>(eye, direction))) {
            continue;
        }
        double from = 0.0;
        double to = 0.0;
        bool more = true;
        while (more && intersector.march(from, to)) {
            // Samples lie at the middles of steps that are counted from the ray's start: no banding at span borders.
            for (double t = (std::ceil(from / step - 0.5) + 0.5) * step; more && t < to; t += step) {
                more = add(user, ray, static_cast<float>(t),
                           openvdb::tools::BoxSampler::sample(accessor, eye + direction * t));
            }
        }
    }
}

} // namespace alpenglow::clouds
