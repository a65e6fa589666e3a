"""What a rig does to a reading on its way to the sensor: levers, gears, several thrusters."""

from collections.abc import Iterator

from pipeline.errors import Problem
from pipeline.ingest.bench_table import Table
from pipeline.ingest.blocks import heading_text
from pipeline.ingest.cells import shorten
from pipeline.ingest.vocabulary import factor_in_name, pattern_of

#: What is measured behind a lever or a gear, by kind of test: quantity, and patterns of the words.
_BEHIND = {
    "mooring": (("thrust", ("lever", "together")),),
    "load_test": (("torque", ("lever", "gear")), ("shaft_speed", ("gear", "poles"))),
}


def factor_unclear(table: Table) -> Iterator[Problem]:
    """Refuse a table whose words speak of a factor that nobody stated for what is measured.

    Words of a lever may stand in any heading, as the name of a column of its lengths, too.
    """
    block, stated = table.block, getattr(table.vehicle.columns, table.kind)
    title = heading_text(block.above)
    beside = [one.header for one in block.columns_not_used(None)]
    for quantity, names in _BEHIND[table.kind]:
        column, mapped = block.columns[quantity], getattr(stated, quantity)
        if mapped is not None and {"scale", "pole_pairs"} & mapped.model_fields_set:
            continue
        own = f"{column.group} {column.header}".strip()
        texts = {name: [own, title, *beside] for name in names}
        if block.thruster is not None:
            texts.pop("together", None)
        said = [
            text for name, every in texts.items() for text in every if pattern_of(name).search(text)
        ]
        if quantity == "thrust" and factor_in_name(title, quantity):
            said.append(title)
        if not said:
            continue
        name = quantity.replace("_", " ")
        if pattern_of("poles").search(said[0]):  # of most motors they are named for the record
            yield table.at(table.head, quantity).warning(
                f'"{shorten(said[0])}" speaks of poles, and "{shorten(column.header)}" is taken '
                "for the speed of the shaft, not of the motor's field.",
                "the speed of the shaft.",
                f"State pole_pairs under columns: {table.kind}: {quantity} in vehicle.yaml.",
            )
            continue
        yield table.leave_out(
            table.at(table.head, quantity).error(
                f'"{shorten(said[0])}" speaks of a lever, a gear, a factor or several thrusters; '
                f"whether the {name} is that at one thruster's shaft is not known. So the table "
                "was left out.",
                f"the factor from what the sensor shows to the {name}.",
                "State it in vehicle.yaml (1 where the numbers hold it already):\n  columns:\n"
                f"    {table.kind}:\n      {quantity}: {{header: "
                f'"{shorten(column.header)}", unit: {column.unit}, scale: ...}}',
            )
        )
