/// The plug-in: one grid of densities of a file, as dense points in their box.
#include "volume_vdb.h"

#include <openvdb/openvdb.h>

#include <cmath>
#include <cstdarg>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <vector>

namespace
{

/// What the converter will say.
char problem_text[RSV_VDB_MESSAGE_BYTES];

__attribute__((format(printf, 2, 3))) rsv_status fail(rsv_status status, const char *format, ...)
{
    va_list values;
    va_start(values, format);
    std::vsnprintf(problem_text, sizeof problem_text, format, values);
    va_end(values);
    return status;
}

using openvdb::CoordBBox;
using openvdb::GridBase;

/// What a file holds that is no density.
std::string list_grids(const openvdb::GridPtrVec &grids)
{
    std::string text;
    for (const auto &grid : grids) {
        if (text.size() > 200) return text + ", ...";
        text += (text.empty() ? "'" : ", '") + grid->getName() + "' of " + grid->valueType();
    }
    return text;
}

bool has_densities(const GridBase &grid)
{
    const std::string type = grid.valueType();
    return (type == "float" || type == "double") && grid.getGridClass() != openvdb::GRID_LEVEL_SET;
}

/// The grid called "density", else the first one of numbers. NULL = there is none.
GridBase::Ptr choose(const openvdb::GridPtrVec &grids)
{
    GridBase::Ptr found;
    for (const auto &grid : grids) {
        if (!has_densities(*grid)) continue;
        if (grid->getName() == "density") return grid;
        if (!found) found = grid;
    }
    return found;
}

rsv_status refuse_size(const CoordBBox &box)
{
    const openvdb::Coord dim = box.dim();
    return fail(RSV_ERROR_UNSUPPORTED,
        "a grid of %d x %d x %d points; at most 2^28 are supported, so make it coarser", dim.x(),
        dim.y(), dim.z());
}

bool is_too_large(const CoordBBox &box)
{
    const double x = double(box.max().x()) - box.min().x() + 3;
    const double y = double(box.max().y()) - box.min().y() + 3;
    const double z = double(box.max().z()) - box.min().z() + 3;
    return x * y * z > RSV_VOLUME_MAX_POINTS;
}

/// Sets the box in the world from that of the points. Grids that are turned or sheared are refused.
rsv_status place(const GridBase &grid, const CoordBBox &box, rsv_vdb_header &header)
{
    const openvdb::math::Transform &transform = grid.transform();
    if (!transform.isLinear())
        return fail(RSV_ERROR_UNSUPPORTED, "its grid is tapered; make it a box");
    const openvdb::Mat4d matrix = transform.baseMap()->getAffineMap()->getMat4();
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++)
            if (row == column ? !(matrix[row][column] > 0)
                              : std::fabs(matrix[row][column]) > 1e-9 * matrix[row][row])
                return fail(RSV_ERROR_UNSUPPORTED,
                    "its grid is turned or mirrored; resample it along the axes");
    const openvdb::Vec3d low = transform.indexToWorld(box.min());
    const openvdb::Vec3d high = transform.indexToWorld(box.max());
    for (int k = 0; k < 3; k++) {
        header.low[k] = float(low[k]);
        header.high[k] = float(high[k]);
        header.side[k] = uint32_t(box.max()[k] - box.min()[k]) + 1;
    }
    return RSV_OK;
}

/// @param box of the points, with an empty layer of one point around it
template <typename Grid>
rsv_status fill(const Grid &grid, const CoordBBox &box, std::vector<float> &density)
{
    const openvdb::Coord dim = box.dim();
    const size_t line = size_t(dim.x()), plane = line * size_t(dim.y());
    if (grid.background() != 0)
        return fail(RSV_ERROR_UNSUPPORTED, "its background density is %g; it must be 0",
            double(grid.background()));
    density.resize(plane * size_t(dim.z()));
    for (auto value = grid.cbeginValueOn(); value; ++value) {
        CoordBBox tile;
        value.getBoundingBox(tile);
        for (auto at = tile.begin(); at; ++at) {
            const openvdb::Coord place = *at - box.min();
            density[size_t(place.z()) * plane + size_t(place.y()) * line + size_t(place.x())] =
                float(*value);
        }
    }
    return RSV_OK;
}

rsv_status send(const rsv_vdb_header &header, const std::vector<float> &density, FILE *answer)
{
    if (std::fwrite(&header, sizeof header, 1, answer) != 1 ||
        std::fwrite(density.data(), sizeof(float), density.size(), answer) != density.size())
        return fail(RSV_ERROR_IO, "its densities cannot be passed on");
    return RSV_OK;
}

template <typename Grid> rsv_status convert_grid(const GridBase &base, FILE *answer)
{
    const auto &grid = static_cast<const Grid &>(base);
    CoordBBox box = grid.evalActiveVoxelBoundingBox();
    rsv_vdb_header header = {};
    std::vector<float> density;
    if (grid.activeVoxelCount() == 0 || box.empty())
        return fail(RSV_ERROR_FORMAT, "its grid '%s' is empty", grid.getName().c_str());
    if (is_too_large(box)) return refuse_size(box);
    box.expand(1);
    rsv_status status = place(grid, box, header);
    if (status == RSV_OK) status = fill(grid, box, density);
    return status == RSV_OK ? send(header, density, answer) : status;
}

/// Whether the file says beforehand that a grid is too large to be read.
bool says_too_large(const GridBase &grid, CoordBBox &box)
{
    const auto low = grid.getMetadata<openvdb::Vec3IMetadata>(GridBase::META_FILE_BBOX_MIN);
    const auto high = grid.getMetadata<openvdb::Vec3IMetadata>(GridBase::META_FILE_BBOX_MAX);
    if (!low || !high) return false;
    box = CoordBBox(openvdb::Coord(low->value()), openvdb::Coord(high->value()));
    return is_too_large(box);
}

rsv_status convert(const char *path, FILE *answer)
{
    openvdb::initialize();
    openvdb::io::File file(path);
    file.open(false);
    const openvdb::GridPtrVec grids = *file.readAllGridMetadata();
    const GridBase::Ptr chosen = choose(grids);
    CoordBBox box;
    if (grids.empty()) return fail(RSV_ERROR_FORMAT, "holds no grid");
    if (!chosen)
        return fail(RSV_ERROR_UNSUPPORTED,
            "holds no grid of densities (single numbers, no level set), only %s",
            list_grids(grids).c_str());
    if (says_too_large(*chosen, box)) return refuse_size(box);
    const GridBase::Ptr grid = file.readGrid(chosen->getName());
    if (grid->valueType() == "float") return convert_grid<openvdb::FloatGrid>(*grid, answer);
    return convert_grid<openvdb::DoubleGrid>(*grid, answer);
}

rsv_status try_to_convert(const char *path, FILE *answer)
{
    try {
        return convert(path, answer);
    } catch (const std::bad_alloc &) {
        return fail(RSV_ERROR_MEMORY, "takes more memory than a file of its size may");
    } catch (const std::exception &problem) {
        return fail(RSV_ERROR_FORMAT, "is damaged or no OpenVDB file (%.200s)", problem.what());
    }
}

} // namespace

extern "C" rsv_status rsv_vdb_convert(
    const char *path, FILE *answer, char message[RSV_VDB_MESSAGE_BYTES]);

extern "C" rsv_status rsv_vdb_convert(
    const char *path, FILE *answer, char message[RSV_VDB_MESSAGE_BYTES])
{
    const rsv_status status = try_to_convert(path, answer);
    std::memcpy(message, problem_text, sizeof problem_text);
    return status;
}
