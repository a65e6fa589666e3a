"""What marks a fill-in workbook, so that a blank one is known for what it is."""

#: Stands in a heading of every form that ``rig2sea new`` writes.
FORM_MARK = "form of rig2sea new"
