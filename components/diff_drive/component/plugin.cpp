// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/diff_drive_component.hpp"
#include "nacelle/node/component.hpp"

NACELLE_REGISTER_COMPONENT(nacelle::diff_drive::DiffDriveComponent)
