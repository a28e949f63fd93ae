#include "device_basis.h"

#include "../core/core.h"
#include "resolvent/measure.h"

/// Objects of plug-ins start with the fields that the library needs.
struct rsv_device_basis {
    rsv_device *device;
};

static const rsv_device_basis_table *table_of(const rsv_device_basis *basis)
{
    return basis->device->table->basis;
}

static rsv_status outcome(rsv_status status, const char *message)
{
    return status == RSV_OK ? RSV_OK : rsv_fail(status, "device: %s", message);
}

rsv_status rsv_device_basis_create(rsv_device *device, uint32_t light_count, size_t receiver_count,
    const float *value, rsv_device_basis **basis)
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    if (receiver_count > UINT32_MAX / 3)
        return rsv_fail(RSV_ERROR_UNSUPPORTED, "device: %zu receivers; at most %u can be relit",
            receiver_count, UINT32_MAX / 3);
    return outcome(
        device->table->basis->create(device, light_count, receiver_count, value, basis, message),
        message);
}

void rsv_device_basis_destroy(rsv_device_basis *basis)
{
    if (basis) table_of(basis)->destroy(basis);
}

rsv_status rsv_device_basis_relight(
    rsv_device_basis *basis, const rsv_rgb *scale, rsv_rgb *irradiance)
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    return outcome(table_of(basis)->relight(basis, scale, irradiance, message), message);
}

const rsv_rgb *rsv_device_basis_address(const rsv_device_basis *basis)
{
    return table_of(basis)->address(basis);
}

rsv_status rsv_device_basis_measure(rsv_device_basis *basis, uint32_t repetitions, double *seconds)
{
    char message[RSV_DEVICE_MESSAGE_BYTES];
    return outcome(table_of(basis)->measure(basis, repetitions, seconds, message), message);
}
