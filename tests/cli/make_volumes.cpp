/// Writes OpenVDB files, good and bad, to the folder that its argument names.
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <fstream>
#include <string>

namespace
{

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::GridBase;

/// A ball of density 1 in the middle of the box from 0 to 1, with cells of 1/16 m.
FloatGrid::Ptr make_ball()
{
    FloatGrid::Ptr grid = FloatGrid::create(0);
    FloatGrid::Accessor at = grid->getAccessor();
    for (int k = 0; k < 17 * 17 * 17; k++) {
        const Coord place(k % 17, k / 17 % 17, k / 17 / 17);
        const openvdb::Vec3i aside = place.asVec3i() - openvdb::Vec3i(8);
        if (aside.lengthSqr() < 40) at.setValue(place, 1);
    }
    grid->setName("density");
    grid->setTransform(openvdb::math::Transform::createLinearTransform(1.0 / 16));
    return grid;
}

void save(const std::string &path, const openvdb::GridPtrVec &grids)
{
    openvdb::io::File(path).write(grids);
}

template <typename Grid> typename Grid::Ptr name_grid(typename Grid::Ptr grid, const char *name)
{
    grid->setName(name);
    return grid;
}

void save_half(const std::string &from, const std::string &to)
{
    std::ifstream in(from, std::ios::binary);
    const std::string all((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    std::ofstream(to, std::ios::binary) << all.substr(0, all.size() / 2);
}

void save_bad_grids(const std::string &folder)
{
    const auto velocity = name_grid<openvdb::Vec3SGrid>(openvdb::Vec3SGrid::create(), "velocity");
    velocity->tree().setValue(Coord(1, 2, 3), openvdb::Vec3s(1));
    save(folder + "vectors.vdb", { velocity });
    save(folder + "empty.vdb", { name_grid<FloatGrid>(FloatGrid::create(0), "density") });
    save(folder + "none.vdb", {});
    const auto huge = name_grid<FloatGrid>(FloatGrid::create(0), "density");
    huge->tree().setValue(Coord(0, 0, 0), 1);
    huge->tree().setValue(Coord(999, 999, 999), 1);
    save(folder + "huge.vdb", { huge });
    const auto endless = name_grid<FloatGrid>(FloatGrid::create(2), "density");
    endless->tree().setValue(Coord(0, 0, 0), 1);
    save(folder + "endless.vdb", { endless });
    const auto negative = make_ball();
    negative->tree().setValue(Coord(1, 1, 1), -1);
    save(folder + "negative.vdb", { negative });
    const auto turned = make_ball();
    turned->transform().postRotate(0.5, openvdb::math::Y_AXIS);
    save(folder + "turned.vdb", { turned });
    save(folder + "surface.vdb",
        { name_grid<FloatGrid>(
            openvdb::tools::createLevelSetSphere<FloatGrid>(1, openvdb::Vec3f(0), 0.1f), "ball") });
}

} // namespace

int main(int argc, char **argv)
{
    if (argc != 2) return 2;
    const std::string folder = std::string(argv[1]) + "/";
    openvdb::initialize();
    const auto velocity = name_grid<openvdb::Vec3SGrid>(openvdb::Vec3SGrid::create(), "velocity");
    save(folder + "ball.vdb", { velocity, make_ball() });
    save_half(folder + "ball.vdb", folder + "half.vdb");
    save_bad_grids(folder);
    return 0;
}
